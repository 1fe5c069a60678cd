/** Notices and findings below the time slider: their texts on hover and focus; a press moves the replay there. */
import { useMemo, useRef, useState } from "preact/hooks";
import type { Timeline } from "../api/types";
import { duration } from "../format";
import { texts } from "../texts";
import { useSize } from "../ui/use_size";
import { type Cluster, clustersOf, type Mark, marksOf } from "./timeline";

/** Width that a finger needs. */
const MARK_PX = 24;
const LISTED = 6;
const SYMBOLS: Readonly<Record<Mark["kind"], string>> = {
  finding: "◆",
  news: "★",
  critical: "▲",
  warning: "△",
  info: "•",
};

interface Props {
  timeline: Timeline;
  /** Moves the replay; null for observers. */
  onGo: ((time_s: number) => void) | null;
}

export function EventMarks({ timeline, onGo }: Props) {
  const element = useRef<HTMLDivElement>(null);
  const width_px = useSize(element)?.width_px ?? 0;
  const length_s = Math.max(timeline.replay.duration_s, 1e-3);
  const clusters = useMemo(
    () => (width_px === 0 ? [] : clustersOf(marksOf(timeline), (MARK_PX / width_px) * length_s)),
    [timeline, width_px],
  );
  // The Tab key stops once at the marks; the arrow keys move from mark to mark.
  const [reached, setReached] = useState(0);
  const [shownIndex, setShownIndex] = useState<number | null>(null);
  const stop = Math.min(reached, clusters.length - 1);
  const press = (event: KeyboardEvent): void => {
    const next = { ArrowLeft: stop - 1, ArrowRight: stop + 1, Home: 0, End: clusters.length - 1 }[event.key];
    if (event.key === "Escape" && shownIndex !== null) setShownIndex(null);
    else if (next === undefined) return;
    else element.current?.querySelectorAll("button")[next]?.focus();
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <div
      ref={element}
      class="replay-events"
      role="toolbar"
      aria-label={texts.replay.events}
      data-testid="replay-events"
      onKeyDown={press}
    >
      {clusters.map((cluster, index) => (
        <button
          key={index}
          type="button"
          class={`replay-event is-${cluster.kind}`}
          style={{ left: `${(100 * cluster.marks[0].time_s) / length_s}%` }}
          tabIndex={index === stop ? 0 : -1}
          aria-label={textsOf(cluster).join("; ")}
          aria-disabled={onGo === null}
          data-count={cluster.marks.length > 1 ? cluster.marks.length : undefined}
          data-testid="replay-event"
          onClick={() => onGo?.(cluster.marks[0].time_s)}
          onFocus={() => {
            setReached(index);
            setShownIndex(index);
          }}
          onBlur={() => setShownIndex(null)}
          onMouseEnter={() => setShownIndex(index)}
          onMouseLeave={() => setShownIndex(null)}
        >
          {SYMBOLS[cluster.kind]}
        </button>
      ))}
      {shownIndex !== null && clusters[shownIndex] && <Tip cluster={clusters[shownIndex]} length_s={length_s} />}
    </div>
  );
}

function Tip({ cluster, length_s }: { cluster: Cluster; length_s: number }) {
  const share = cluster.marks[0].time_s / length_s;
  const place = share < 0.5 ? { left: `${100 * share}%` } : { right: `${100 * (1 - share)}%` };
  return (
    <ul class="replay-tip" style={place} aria-hidden="true" data-testid="replay-tip">
      {textsOf(cluster).map((lines, index) => (
        <li key={index}>{lines}</li>
      ))}
    </ul>
  );
}

function textsOf({ marks }: Cluster): string[] {
  const lines = marks.slice(0, LISTED).map(({ time_s, text }) => `${duration(time_s)} ${text}`);
  return marks.length > LISTED ? [...lines, texts.replay.more(marks.length - LISTED)] : lines;
}
