/** Alerts that nobody has acknowledged: the worst one in words, the others behind it. */
import { useState } from "preact/hooks";
import type { Alert } from "../state/alerts";
import { duration } from "../format";
import { texts } from "../texts";
import { Dialog } from "../ui/dialog";
import { sentence } from "./use_alerts";

interface Props {
  alerts: readonly Alert[];
  onAcknowledge(alerts: readonly Alert[]): void;
}

export function AlertBar({ alerts, onAcknowledge }: Props) {
  const [isListOpen, setListOpen] = useState(false);
  const [first, ...others] = alerts;
  if (first === undefined) return <div role="alert" />;
  return (
    <div class={`alert-bar is-${first.severity}`} data-testid="alert-bar" data-severity={first.severity}>
      {/* Only the words are announced: buttons that change would repeat themselves. */}
      <p role="alert">
        <b>{texts.alerts.severity[first.severity]}</b> {sentence(first)}
        {first.count > 1 && ` (${texts.alerts.times(first.count)})`}
      </p>
      {others.length > 0 && (
        <button type="button" data-testid="alert-list" onClick={() => setListOpen(true)}>
          {texts.alerts.more(others.length)}
        </button>
      )}
      <button type="button" data-testid="alert-acknowledge" onClick={() => onAcknowledge([first])}>
        {texts.alerts.acknowledge}
      </button>
      {isListOpen && (
        <Dialog title={texts.alerts.panel} testId="alert-dialog" onClose={() => setListOpen(false)}>
          <ul class="alert-list">
            {alerts.map((alert) => (
              <li key={alert.key} class={`is-${alert.severity}`}>
                <time>{duration(alert.elapsed_s)}</time> <b>{texts.alerts.severity[alert.severity]}</b>{" "}
                {sentence(alert)} {alert.count > 1 && texts.alerts.times(alert.count)}
              </li>
            ))}
          </ul>
          <div class="dialog-buttons">
            <button type="button" data-testid="alert-acknowledge-all" onClick={() => onAcknowledge(alerts)}>
              {texts.alerts.acknowledgeAll(alerts.length)}
            </button>
          </div>
        </Dialog>
      )}
    </div>
  );
}
