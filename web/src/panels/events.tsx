/** What has happened, newest first, filtered by severity. */
import { useState } from "preact/hooks";
import type { Notice, Severity } from "../api/types";
import { duration } from "../format";
import { texts } from "../texts";

const SEVERITIES: readonly Severity[] = ["info", "warning", "critical"];

export function EventsPanel({ notices }: { notices: readonly Notice[] }) {
  const [lowest, setLowest] = useState<Severity>("info");
  const rank = (severity: Severity): number => SEVERITIES.indexOf(severity);
  const shown = notices.filter((notice) => rank(notice.severity) >= rank(lowest)).reverse();
  return (
    <section class="events panel" aria-label={texts.events.panel} data-testid="events">
      <div class="panel-head">
        <h2>{texts.events.panel}</h2>
        <div class="tabs" role="group" aria-label={texts.events.panel}>
          {SEVERITIES.map((severity) => (
            <button
              key={severity}
              type="button"
              data-testid={`events-${severity}`}
              aria-pressed={severity === lowest}
              onClick={() => setLowest(severity)}
            >
              {severity === "info" ? texts.events.all : texts.events.severity[severity]}
            </button>
          ))}
        </div>
      </div>
      <ol aria-live="polite">
        {shown.length === 0 && <li class="empty">{texts.events.none}</li>}
        {shown.map((notice, index) => (
          <li key={shown.length - index} class={`event is-${notice.severity}`} data-testid="event">
            <time>{duration(notice.elapsed_s)}</time>
            <span>
              {notice.severity !== "info" && <b>{texts.events.severity[notice.severity]} </b>}
              {notice.vehicle_id !== null && `${texts.events.vehicle} ${notice.vehicle_id}: `}
              {notice.text}
            </span>
          </li>
        ))}
      </ol>
    </section>
  );
}
