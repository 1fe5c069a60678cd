/** The buttons that command the vehicles, and what became of the last command. */
import { useEffect, useRef, useState } from "preact/hooks";
import { type ActionAnswer, postAction } from "../api/client";
import type { Action, Mission } from "../api/types";
import { scope } from "../format";
import { asksFirst, isOffered, targets } from "../state/commands";
import { texts } from "../texts";
import { Dialog } from "./dialog";
import { Results } from "./results";
import { Target } from "./target";

const MISSION_ACTIONS: readonly Action[] = ["start", "pause", "resume"];
const ENDING_ACTIONS: readonly Action[] = ["return", "land", "abort"];
const HOLD_KEY = "h";

/** An action with its vehicles, fixed when it was asked for: what is confirmed is what is sent. */
interface Command {
  action: Action;
  vehicleIds: readonly number[] | null;
  label: string;
}

interface Props {
  mission: Mission | null;
  isConnected: boolean;
  selected: ReadonlySet<number>;
  onClearSelection(): void;
}

function makeCommand(action: Action, selected: ReadonlySet<number>): Command {
  const vehicleIds = targets(action, selected);
  const isMission = action === "start" || action === "abort";
  return {
    action,
    vehicleIds,
    label: texts.actions.label(action, isMission ? texts.scope.mission : scope(vehicleIds)),
  };
}

export function Controls({ mission, isConnected, selected, onClearSelection }: Props) {
  const [asked, setAsked] = useState<Command | null>(null);
  const [last, setLast] = useState<{ label: string; answer: ActionAnswer | null } | null>(null);

  const send = async ({ action, vehicleIds, label }: Command): Promise<void> => {
    setAsked(null);
    setLast({ label, answer: null });
    setLast({ label, answer: await postAction(action, vehicleIds) });
  };
  const request = (action: Action): void => {
    const command = makeCommand(action, selected);
    if (asksFirst(action)) setAsked(command);
    else void send(command);
  };
  const canAct = (action: Action): boolean => isConnected && isOffered(action, mission, selected);
  useHoldKey(() => canAct("hold") && request("hold"));

  const button = (action: Action) => (
    <ActionButton
      key={action}
      action={action}
      label={makeCommand(action, selected).label}
      isEnabled={canAct(action)}
      onPress={() => request(action)}
    />
  );
  return (
    <section class="controls panel" aria-label={texts.actions.panel} data-testid="controls">
      <p class="scope">
        <span>
          {texts.scope.label} <strong data-testid="scope">{scope(targets("hold", selected))}</strong>
        </span>
        {selected.size > 0 && (
          <button type="button" class="quiet" data-testid="clear-selection" onClick={onClearSelection}>
            {texts.scope.clear}
          </button>
        )}
      </p>
      {button("hold")}
      <div class="button-grid">{MISSION_ACTIONS.map(button)}</div>
      <div class="button-grid">{ENDING_ACTIONS.map(button)}</div>
      <p class="message" data-testid="message" role="status">
        {mission?.message ?? texts.waiting}
      </p>
      {last && <Results label={last.label} answer={last.answer} />}
      <Target mission={mission} />
      {asked && (
        <Dialog title={`${asked.label}?`} testId="confirm" onClose={() => setAsked(null)}>
          <p>{texts.actions.question[asked.action]}</p>
          <div class="dialog-buttons">
            <button type="button" data-testid="confirm-cancel" onClick={() => setAsked(null)}>
              {texts.actions.cancel}
            </button>
            <button type="button" class="danger" data-testid="confirm-ok" onClick={() => void send(asked)}>
              {asked.label}
            </button>
          </div>
        </Dialog>
      )}
    </section>
  );
}

/** Call `onHold` when the key is pressed anywhere, also above an open question. */
function useHoldKey(onHold: () => void): void {
  const handler = useRef(onHold);
  handler.current = onHold;
  useEffect(() => {
    const listen = (event: KeyboardEvent): void => {
      const isPlain = !event.ctrlKey && !event.metaKey && !event.altKey && !event.repeat;
      if (isPlain && event.key.toLowerCase() === HOLD_KEY) handler.current();
    };
    // A select would otherwise take the letter as a search for an option.
    window.addEventListener("keydown", listen, { capture: true });
    return () => window.removeEventListener("keydown", listen, { capture: true });
  }, []);
}

interface ButtonProps {
  action: Action;
  label: string;
  isEnabled: boolean;
  onPress(): void;
}

function ActionButton({ action, label, isEnabled, onPress }: ButtonProps) {
  const isHold = action === "hold";
  return (
    <button
      type="button"
      class={`action action-${action}`}
      data-testid={`action-${action}`}
      aria-label={label}
      aria-keyshortcuts={isHold ? "H" : undefined}
      title={isEnabled ? label : texts.actions.unavailable}
      disabled={!isEnabled}
      onClick={onPress}
    >
      {isHold ? label : texts.actions.verb[action]}
      {isHold && <small>{texts.actions.holdKey}</small>}
    </button>
  );
}
