/** Events, newest first, filtered by severity, with their acknowledgements. */
import { useMemo, useState } from "preact/hooks";
import type { Acknowledgement, Finding, Notice, Severity } from "../api/types";
import type { Notation } from "../coordinates";
import { duration, timeOfDay } from "../format";
import { useShell } from "../shell/context";
import { findingText } from "../shell/finding_text";
import { routeHash } from "../shell/route";
import { acknowledgementByNotice, SEVERITIES } from "../state/alerts";
import { findingOfTrack } from "../state/findings";
import { said, texts } from "../texts";
import { Choice } from "../ui/choice";
import { Panel } from "../ui/panel";

/** Lowest severity that is shown. */
const FILTERS = ["info", "warning", "critical"] as const satisfies readonly Severity[];

const rank = (severity: Severity): number => SEVERITIES.indexOf(severity);

interface Props {
  notices: readonly Notice[];
  acknowledgements: readonly Acknowledgement[];
}

export function EventsPanel({ notices, acknowledgements }: Props) {
  const [lowest, setLowest] = useState<(typeof FILTERS)[number]>("info");
  const { state, notation } = useShell();
  const findings = state.mission?.findings;
  const items = useMemo(() => {
    const acknowledged = acknowledgementByNotice(notices, acknowledgements);
    return notices.flatMap((notice, index) => {
      const { notice_id: id } = notice;
      const missing = id - (notices[index - 1]?.notice_id ?? 0) - 1;
      const isShown = rank(notice.severity) >= rank(lowest);
      return [
        missing > 0 ? <MissingItem key={`before ${id}`} count={missing} /> : null,
        isShown ? (
          <EventItem
            key={id}
            notice={notice}
            acknowledgement={acknowledged.get(id)}
            finding={findingOfTrack(findings ?? [], notice.track_id)}
            notation={notation}
          />
        ) : null,
      ].filter((item) => item !== null);
    });
  }, [notices, acknowledgements, lowest, findings, notation]);
  const choice = (
    <Choice
      label={texts.events.panel}
      testId="events"
      values={FILTERS}
      chosen={lowest}
      labels={{ ...texts.names.severity, info: texts.events.all }}
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
  /** Finding that it is about; null for anything else. */
  finding: Finding | null;
  notation: Notation;
}

function EventItem({ notice, acknowledgement, finding, notation }: ItemProps) {
  const { severity, utc_s, elapsed_s } = notice;
  return (
    <li class={`event is-${severity}`} data-testid="event">
      <time title={elapsed_s > 0 ? texts.events.missionTime(duration(elapsed_s)) : ""}>{timeOfDay(utc_s)}</time>
      <span>
        {severity !== "info" && <b>{texts.names.severity[severity]} </b>}
        <EventWords notice={notice} finding={finding} notation={notation} />
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

/** Words of an event; about a finding, what is known of it now, as a link to its card. */
function EventWords({
  notice: { text, vehicle_id: id },
  finding,
  notation,
}: Pick<ItemProps, "notice" | "finding" | "notation">) {
  if (finding === null) return id === null ? said(text) : texts.alerts.vehicle(id, said(text));
  return (
    <a href={routeHash("decide", { finding: String(finding.finding_id) })} title={said(text)}>
      {findingText(finding, notation)}
    </a>
  );
}

function MissingItem({ count }: { count: number }) {
  return (
    <li class="event small" data-testid="events-missing">
      {texts.events.missing(count)}
    </li>
  );
}
