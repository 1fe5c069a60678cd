/** Events, newest first, filtered by severity, with their acknowledgements. */
import { useMemo, useState } from "preact/hooks";
import type { Acknowledgement, Notice, Severity } from "../api/types";
import { timeOfDay } from "../format";
import { acknowledgementByNotice, SEVERITIES } from "../state/alerts";
import { texts } from "../texts";
import { Choice } from "../ui/choice";
import { Panel } from "../ui/panel";

/** Lowest severity that is shown. */
const FILTERS = ["info", "warning", "critical"] as const satisfies readonly Severity[];
const WORDS: Readonly<Record<Severity, string>> = { ...texts.names.severity, info: texts.events.all };

const rank = (severity: Severity): number => SEVERITIES.indexOf(severity);

interface Props {
  notices: readonly Notice[];
  acknowledgements: readonly Acknowledgement[];
}

export function EventsPanel({ notices, acknowledgements }: Props) {
  const [lowest, setLowest] = useState<(typeof FILTERS)[number]>("info");
  const items = useMemo(() => {
    const acknowledged = acknowledgementByNotice(notices, acknowledgements);
    return notices.flatMap((notice, index) => {
      const { notice_id: id } = notice;
      const missing = id - (notices[index - 1]?.notice_id ?? 0) - 1;
      const isShown = rank(notice.severity) >= rank(lowest);
      return [
        missing > 0 ? <MissingItem key={`before ${id}`} count={missing} /> : null,
        isShown ? <EventItem key={id} notice={notice} acknowledgement={acknowledged.get(id)} /> : null,
      ].filter((item) => item !== null);
    });
  }, [notices, acknowledgements, lowest]);
  const choice = (
    <Choice
      label={texts.events.panel}
      testId="events"
      values={FILTERS}
      chosen={lowest}
      labels={WORDS}
      onChoose={setLowest}
    />
  );
  return (
    <Panel title={texts.events.panel} testId="events" class="events" aside={choice}>
      <ol tabIndex={0} aria-label={texts.events.panel}>
        {items.length === 0 ? <li class="empty">{texts.events.none}</li> : items.toReversed()}
      </ol>
    </Panel>
  );
}

interface ItemProps {
  notice: Notice;
  acknowledgement: Acknowledgement | undefined;
}

function EventItem({ notice: { severity, text, vehicle_id: id, utc_s }, acknowledgement }: ItemProps) {
  return (
    <li class={`event is-${severity}`} data-testid="event">
      <time>{timeOfDay(utc_s)}</time>
      <span>
        {severity !== "info" && <b>{texts.names.severity[severity]} </b>}
        {id === null ? text : texts.alerts.vehicle(id, text)}
        {acknowledgement && (
          <small data-testid="acknowledged">
            {" "}
            ({texts.alerts.acknowledged(acknowledgement.operator, timeOfDay(acknowledgement.utc_s))})
          </small>
        )}
      </span>
    </li>
  );
}

function MissingItem({ count }: { count: number }) {
  return (
    <li class="event small" data-testid="events-missing">
      {texts.events.missing(count)}
    </li>
  );
}
