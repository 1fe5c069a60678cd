/** Alerts that no operator has acknowledged: the most severe one in words, the others in a list. */
import { useState } from "preact/hooks";
import { acknowledgeNotices } from "../api/client";
import type { Finding } from "../api/types";
import { timeOfDay } from "../format";
import type { Alert } from "../state/alerts";
import { findingOfTrack } from "../state/findings";
import { texts } from "../texts";
import { Dialog } from "../ui/dialog";
import { useShell } from "./context";
import { findingWords } from "./finding_text";
import { routeHash } from "./route";
import { alertText } from "./use_alerts";

interface Props {
  alerts: readonly Alert[];
  /** Whether this page may acknowledge alerts; operators do so for all screens. */
  mayAcknowledge: boolean;
}

export function AlertBar({ alerts, mayAcknowledge }: Props) {
  const { state, notation } = useShell();
  const findingOf = (alert: Alert): Finding | null => findingOfTrack(state.mission?.findings ?? [], alert.trackId);
  const words = (alert: Alert): string => {
    const finding = findingOf(alert);
    return finding === null ? alertText(alert) : findingWords(finding, notation);
  };
  // The number of a finding says that something was found: two lines have room for the rest.
  const label = (alert: Alert): string => {
    const finding = findingOf(alert);
    return finding === null ? texts.names.severity[alert.severity] : texts.decide.finding(finding.finding_id);
  };
  const [isListOpen, setListOpen] = useState(false);
  const [refusal, setRefusal] = useState("");
  const acknowledge = async (those: readonly Alert[]): Promise<void> => {
    const answer = await acknowledgeNotices(those.flatMap(({ ids }) => ids));
    setRefusal(answer.ok ? "" : answer.message);
  };
  const [first, ...others] = alerts;
  if (first === undefined) {
    return (
      <section class="alert-bar" aria-label={texts.alerts.panel}>
        <p role="alert" />
        <p class="small">{texts.alerts.none}</p>
      </section>
    );
  }
  return (
    <section
      class={`alert-bar is-${first.severity}`}
      aria-label={texts.alerts.panel}
      data-testid="alert-bar"
      data-severity={first.severity}
    >
      {/* Only the words are announced: buttons that change would repeat themselves. */}
      <p role="alert" tabIndex={0}>
        <b>{label(first)}</b> {words(first)}
        {first.count > 1 && ` (${texts.alerts.times(first.count)})`}
      </p>
      <ShowFinding finding={findingOf(first)} />
      {refusal !== "" && <p data-testid="alert-refusal">{refusal}</p>}
      {others.length > 0 && (
        <button type="button" data-testid="alert-list" onClick={() => setListOpen(true)}>
          {texts.alerts.more(others.length)}
        </button>
      )}
      {mayAcknowledge && (
        <button type="button" data-testid="alert-acknowledge" onClick={() => void acknowledge([first])}>
          {texts.alerts.acknowledge}
        </button>
      )}
      {isListOpen && (
        <Dialog title={texts.alerts.panel} testId="alert-dialog" onClose={() => setListOpen(false)}>
          <ul class="alert-list">
            {alerts.map((alert) => (
              <li key={alert.key} class={`is-${alert.severity}`}>
                <time>{timeOfDay(alert.utc_s)}</time> <b>{label(alert)}</b> {words(alert)}{" "}
                {alert.count > 1 && texts.alerts.times(alert.count)}
                <ShowFinding finding={findingOf(alert)} onFollow={() => setListOpen(false)} />
              </li>
            ))}
          </ul>
          <div class="dialog-buttons">
            {mayAcknowledge && (
              <button type="button" data-testid="alert-acknowledge-all" onClick={() => void acknowledge(alerts)}>
                {texts.alerts.acknowledgeAll(alerts.length)}
              </button>
            )}
          </div>
        </Dialog>
      )}
    </section>
  );
}

/** Link to the card of the finding that an alert is about. */
function ShowFinding({ finding, onFollow }: { finding: Finding | null; onFollow?: () => void }) {
  if (finding === null) return null;
  const { finding_id: id } = finding;
  return (
    <a
      class="button show-finding"
      href={routeHash("decide", { finding: String(id) })}
      data-testid={`show-finding-${id}`}
      aria-label={texts.alerts.showFinding(id)}
      onClick={onFollow}
    >
      {texts.alerts.show}
    </a>
  );
}
