/** What has happened, newest first, filtered by severity. */
import { useMemo, useState } from "preact/hooks";
import type { Severity } from "../api/types";
import { duration } from "../format";
import type { NumberedNotice } from "../state/state";
import { texts } from "../texts";
import { Choice } from "../ui/choice";
import { Panel } from "../ui/panel";

const SEVERITIES: readonly Severity[] = ["info", "warning", "critical"];
const WORDS: Readonly<Record<Severity, string>> = { ...texts.alerts.severity, info: texts.events.all };

const rank = (severity: Severity): number => SEVERITIES.indexOf(severity);

export function EventsPanel({ notices }: { notices: readonly NumberedNotice[] }) {
  const [lowest, setLowest] = useState<Severity>("info");
  const items = useMemo(() => {
    const shown = notices.filter((notice) => rank(notice.severity) >= rank(lowest));
    return shown.reverse().map((notice) => <EventItem key={notice.id} notice={notice} />);
  }, [notices, lowest]);
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
        {items.length === 0 ? <li class="empty">{texts.events.none}</li> : items}
      </ol>
    </Panel>
  );
}

function EventItem({ notice: { severity, text, vehicle_id: id, elapsed_s } }: { notice: NumberedNotice }) {
  return (
    <li class={`event is-${severity}`} data-testid="event">
      <time>{duration(elapsed_s)}</time>
      <span>
        {severity !== "info" && <b>{texts.alerts.severity[severity]} </b>}
        {id !== null && `${texts.alerts.vehicle(id)}: `}
        {text}
      </span>
    </li>
  );
}
