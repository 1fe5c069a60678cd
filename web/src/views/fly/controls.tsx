/** Command buttons for the selected vehicles, or all, and the results of recent commands. */
import type { Action } from "../../api/types";
import { useShell } from "../../shell/context";
import { Reports } from "../../shell/reports";
import { areGrounded, isOffered, makeCommand } from "../../state/commands";
import { select } from "../../state/selection";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";

/** Those that are shown only while they are available come last: the other buttons do not move when they appear. */
const ACTIONS: readonly Action[] = [
  "hold",
  "pause",
  "resume",
  "start",
  "return",
  "land",
  "abort",
  "join",
  "ready",
  "not_ready",
  "new_sortie",
];
const SHOWN_IF_AVAILABLE: ReadonlySet<Action> = new Set<Action>(["join", "ready", "not_ready", "new_sortie"]);

export function Controls() {
  const { state, isConnected, mayCommand, selection, changeSelection, commands } = useShell();
  const { mission } = state;
  const { ids } = selection;
  const areAllGrounded = mission !== null && areGrounded(mission, ids);
  const phaseReason = areAllGrounded ? texts.onGround : texts.unavailable;
  const reason = isConnected ? phaseReason : texts.requests.noConnection;
  const fleet = mission?.vehicles.length ?? 0;
  const scope =
    ids.size === 0
      ? texts.scope.all(fleet)
      : texts.scope.some(
          [...ids].sort((a, b) => a - b),
          fleet,
        );
  return (
    <Panel title={mayCommand ? texts.actions.panel : texts.scope.selection} testId="controls" class="controls">
      <p class="scope">
        <span>
          {mayCommand && texts.scope.label} <strong data-testid="scope">{scope}</strong>
        </span>
        <button
          type="button"
          data-testid="clear-selection"
          disabled={ids.size === 0}
          onClick={() => changeSelection((before) => select(before, []))}
        >
          {texts.scope.clear}
        </button>
      </p>
      {mayCommand && (
        <div class="actions">
          {ACTIONS.map((action) => {
            const { label } = makeCommand(action, mission, ids);
            const isEnabled = isConnected && isOffered(action, mission, ids);
            if (SHOWN_IF_AVAILABLE.has(action) && !isEnabled) return null;
            return (
              <button
                key={action}
                type="button"
                class={`action action-${action}`}
                data-testid={`action-${action}`}
                aria-label={label}
                title={isEnabled ? label : reason}
                disabled={!isEnabled}
                onClick={() => commands.request(action)}
              >
                {texts.names.action[action]}
              </button>
            );
          })}
        </div>
      )}
      {mayCommand && (
        <section class="last-commands" tabIndex={0} aria-label={texts.actions.results}>
          <h3>{texts.actions.results}</h3>
          {commands.reports.length === 0 && <p class="small">{texts.actions.noResults}</p>}
          <Reports reports={commands.reports} />
        </section>
      )}
    </Panel>
  );
}
