/** Time of a recorded mission, below the tabs of every view. */
import { useEffect, useMemo, useState } from "preact/hooks";
import { Newest } from "../api/newest";
import { controlReplay, readTimeline } from "../api/replay";
import type { Replay, ReplayRequest, Timeline } from "../api/types";
import { duration } from "../format";
import { texts } from "../texts";
import { EventMarks } from "./marks";
import { keyChange, marksOf, neighbour_s, phaseSpans, SPEEDS, toggled } from "./timeline";
import { useReplayKeys } from "./use_replay_keys";
import "./replay.css";

/** Resolution of the slider; the duration of a replay is a multiple of it. */
const SLIDER_STEP_S = 0.1;

interface Props {
  replay: Replay;
  missionId: string;
  /** Whether this page may move the replay: operators only. */
  mayControl: boolean;
}

export function ReplayBar({ replay, missionId, mayControl }: Props) {
  const [timeline, setTimeline] = useState<Timeline | null>(null);
  const [problem, setProblem] = useState("");
  const [requested, setRequested] = useState<ReplayRequest>({});
  useEffect(() => {
    void readTimeline().then((answer) => {
      if (answer.ok) setTimeline(answer.value);
      else setProblem(answer.message);
    });
  }, [missionId]);

  // Marks the browser tab, so that a replay is not taken for a flight.
  useEffect(() => {
    const title = document.title;
    document.title = `${texts.replay.mark} ${missionId} · ${title}`;
    return () => {
      document.title = title;
    };
  }, [missionId]);

  const newest = useMemo(
    () =>
      new Newest<ReplayRequest>(async (change) => {
        const answer = await controlReplay(change);
        setProblem(answer.ok ? "" : answer.message);
        if (!answer.ok) setRequested({});
      }),
    [],
  );
  // The requested time is shown until the station reports it.
  useEffect(() => {
    if (newest.isIdle) setRequested({});
  }, [replay]);
  const shown: Replay = { ...replay, ...known(requested) };
  const change = (asked: ReplayRequest): void => {
    // One request combines all recent changes, since only the newest is sent.
    const all = { ...requested, ...asked };
    setRequested(all);
    newest.ask(all);
  };
  useReplayKeys((key) => {
    const asked = mayControl && timeline !== null ? keyChange(key, timeline, shown) : null;
    if (asked !== null) change(asked);
    return asked !== null;
  });

  return (
    <section class="replay-bar" aria-label={texts.replay.bar} data-testid="replay-bar">
      <strong class="replay-mark">{texts.replay.mark}</strong>
      {mayControl && <Buttons shown={shown} timeline={timeline} onChange={change} />}
      <div class="replay-track">
        <input
          type="range"
          min={0}
          max={replay.duration_s}
          step={SLIDER_STEP_S}
          value={shown.time_s}
          disabled={!mayControl}
          aria-label={texts.replay.time}
          aria-valuetext={duration(shown.time_s)}
          data-testid="replay-time"
          onInput={(event) => change({ time_s: event.currentTarget.valueAsNumber })}
        />
        {timeline && (
          <>
            <EventMarks timeline={timeline} onGo={mayControl ? (time_s) => change({ time_s }) : null} />
            <Phases timeline={timeline} />
          </>
        )}
      </div>
      <output data-testid="replay-clock">
        {duration(shown.time_s)} / {duration(replay.duration_s)}
      </output>
      {problem !== "" && (
        <p class="is-bad" role="alert">
          {problem}
        </p>
      )}
    </section>
  );
}

interface ButtonsProps {
  shown: Replay;
  timeline: Timeline | null;
  onChange(asked: ReplayRequest): void;
}

function Buttons({ shown, timeline, onChange }: ButtonsProps) {
  const { replay: labels } = texts;
  const marks = useMemo(() => (timeline === null ? [] : marksOf(timeline)), [timeline]);
  const leap = (moments: readonly { time_s: number }[], direction: 1 | -1, label: string, testId: string) => {
    const time_s = neighbour_s(moments, shown.time_s, direction);
    return (
      <button
        type="button"
        disabled={time_s === null}
        data-testid={testId}
        onClick={() => time_s !== null && onChange({ time_s })}
      >
        {label}
      </button>
    );
  };
  const steps = timeline?.steps ?? [];
  return (
    <div class="replay-buttons">
      {leap(marks, -1, labels.eventBefore, "replay-event-before")}
      {leap(steps, -1, labels.stepBefore, "replay-step-before")}
      <button type="button" class="primary" data-testid="replay-play" onClick={() => onChange(toggled(shown))}>
        {shown.playing ? labels.stop : labels.play}
      </button>
      {leap(steps, 1, labels.stepAfter, "replay-step-after")}
      {leap(marks, 1, labels.eventAfter, "replay-event-after")}
      <label>
        <span class="visually-hidden">{labels.speed}</span>
        <select
          data-testid="replay-speed"
          value={String(shown.speed)}
          onChange={(event) => onChange({ speed: Number(event.currentTarget.value) })}
        >
          {SPEEDS.map((speed) => (
            <option key={speed} value={String(speed)}>
              {labels.times(speed)}
            </option>
          ))}
        </select>
      </label>
    </div>
  );
}

/** Phases as bands with their names, steps as ticks. They are decorative: the slider and its keys do the same. */
function Phases({ timeline }: { timeline: Timeline }) {
  const { duration_s } = timeline.replay;
  const percent = (time_s: number): number => (100 * time_s) / Math.max(duration_s, 1e-3);
  const ticks = timeline.steps.map(({ time_s }) => `M${percent(time_s)} 0V1`).join("");
  return (
    <div class="replay-phases" aria-hidden="true">
      <svg viewBox="0 0 100 1" preserveAspectRatio="none">
        <path d={ticks} />
      </svg>
      {phaseSpans(timeline).map(({ phase, from_s, to_s }) => (
        <span
          key={from_s}
          title={texts.replay.phaseAt(texts.names.phase[phase], duration(from_s))}
          style={{ left: `${percent(from_s)}%`, width: `${percent(to_s - from_s)}%` }}
        >
          {texts.names.phase[phase]}
        </span>
      ))}
    </div>
  );
}

/** Fields that are given: null or missing ones leave the replay as it is. */
function known({ time_s, speed, playing }: ReplayRequest): Partial<Replay> {
  return {
    ...(typeof time_s === "number" && { time_s }),
    ...(typeof speed === "number" && { speed }),
    ...(typeof playing === "boolean" && { playing }),
  };
}
