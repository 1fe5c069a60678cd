/** Blocking issues, and the launch button. */
import type { Phase, PreflightCheck } from "../../api/types";
import { useShell } from "../../shell/context";
import { isOffered } from "../../state/commands";
import { said, texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { blockersOf, nameOf, subjectOf } from "./checks";

const BEFORE_START: ReadonlySet<Phase> = new Set<Phase>(["connect", "preflight", "ready"]);

interface Props {
  checks: readonly PreflightCheck[];
  onChoose(key: string): void;
}

export function LaunchPanel({ checks, onChoose }: Props) {
  const { state, isConnected, mayCommand, commands } = useShell();
  const { mission } = state;
  const blockers = blockersOf(checks);
  const warnings = checks.filter(({ status }) => status === "warn").length;
  const isAllowed = isConnected && isOffered("start", mission, new Set());
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
          {checks.length > 0 && blockers.length === 0 && <li class="is-done">{texts.prepare.noBlockers(warnings)}</li>}
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
      {mayCommand && (
        <button
          type="button"
          class="action action-start launch-button"
          data-testid="launch"
          disabled={!isAllowed}
          title={isAllowed ? undefined : texts.unavailable}
          onClick={() => commands.request("start")}
        >
          {texts.prepare.launch}
        </button>
      )}
    </Panel>
  );
}
