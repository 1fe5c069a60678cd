/** What has happened, newest first, filtered by severity. */
import { useState } from "preact/hooks";
import type { Severity } from "../api/types";
import { duration } from "../format";
import type { NumberedNotice } from "../state/state";
import { texts } from "../texts";
import { Choice } from "../ui/choice";
import { Panel } from "../ui/panel";

const SEVERITIES: readonly Severity[] = ["info", "warning", "critical"];
const WORDS: Readonly<Record<Severity, string>> = { ...texts.alerts.severity, info: texts.events.all };

export function EventsPanel({ notices }: { notices: readonly NumberedNotice[] }) {
  const [lowest, setLowest] = useState<Severity>("info");
  const rank = (severity: Severity): number => SEVERITIES.indexOf(severity);
  const shown = notices.filter((notice) => rank(notice.severity) >= rank(lowest)).reverse();
  const choice = (
    <Choice
      label={texts.events.panel}
      testId="events"
      values={SEVERITIES}
      chosen={lowest}
      words={WORDS}
      onChoose={setLowest}
    />
  );
  return (
    <Panel title={texts.events.panel} testId="events" class="events" aside={choice}>
      <ol tabIndex={0} aria-label={texts.events.panel}>
        {shown.length === 0 && <li class="empty">{texts.events.none}</li>}
        {shown.map((notice) => (
          <li key={notice.id} class={`event is-${notice.severity}`} data-testid="event">
            <time>{duration(notice.elapsed_s)}</time>
            <span>
              {notice.severity !== "info" && <b>{texts.alerts.severity[notice.severity]} </b>}
              {notice.vehicle_id !== null && `${texts.alerts.vehicle(notice.vehicle_id)}: `}
              {notice.text}
            </span>
          </li>
        ))}
      </ol>
    </Panel>
  );
}
