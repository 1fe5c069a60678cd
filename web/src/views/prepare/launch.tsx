/** Blocking issues, and the launch. */
import type { PreflightCheck } from "../../api/types";
import { useShell } from "../../shell/context";
import { BEFORE_START, isOffered } from "../../state/commands";
import { said, texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { blockersOf, nameOf, subjectOf, warningsOf, withoutConfirmation } from "./checks";
import { LaunchHold } from "./launch_hold";
import { isProposal } from "./vehicles";

interface Props {
  checks: readonly PreflightCheck[];
  /** Vehicles that are to fly. */
  vehicles: readonly number[];
  onChoose(key: string): void;
  /** The station has taken over the vehicles. */
  onConfirmed(vehicles: readonly number[]): void;
}

export function LaunchPanel({ checks, vehicles, onChoose, onConfirmed }: Props) {
  const { state, isConnected, mayCommand, asked, commands } = useShell();
  const isOffering = mayCommand || asked !== null;
  const { mission } = state;
  // What only waits for the confirmation is no issue: the button below confirms, too.
  const isProposed = isOffering && mission !== null && isProposal(mission, vehicles);
  const shown = isProposed ? withoutConfirmation(checks, vehicles) : checks;
  const blockers = blockersOf(shown);
  const warnings = warningsOf(shown).size;
  if (mission !== null && !BEFORE_START.has(mission.phase)) {
    const isOver = mission.phase === "done";
    return (
      <Panel title={texts.prepare.launch} testId="launch-panel" class="launch">
        <p class="empty">{isOver ? texts.prepare.over : texts.prepare.inFlight}</p>
        {mayCommand && isOver && (
          <button
            type="button"
            class="action launch-button"
            data-testid="new-sortie"
            disabled={!isConnected || !isOffered("new_sortie", mission, new Set())}
            onClick={() => commands.request("new_sortie")}
          >
            {texts.names.action.new_sortie}
          </button>
        )}
      </Panel>
    );
  }
  return (
    <Panel title={texts.prepare.launch} testId="launch-panel" class="launch">
      <div class="scroll">
        <h3>{texts.prepare.blockers}</h3>
        <ul data-testid="preflight-problems" aria-live="polite">
          {checks.length === 0 && <li>{texts.prepare.none}</li>}
          {checks.length > 0 && blockers.length === 0 && (
            <li class="is-done">
              {isProposed ? texts.prepare.toConfirm(warnings) : texts.prepare.noBlockers(warnings)}
            </li>
          )}
          {blockers.map(({ key, ids, name, text }) => (
            <li key={key}>
              <button type="button" class="link" onClick={() => onChoose(key)}>
                <b class="is-bad">
                  {subjectOf(...ids)}, {nameOf(name)}:
                </b>{" "}
                {said(text)}
              </button>
            </li>
          ))}
        </ul>
      </div>
      {isOffering && mission !== null && (
        <LaunchHold mission={mission} checks={checks} vehicles={vehicles} onConfirmed={onConfirmed} />
      )}
    </Panel>
  );
}
