/** The vehicles that fly: proposed by the page, confirmed by an operator. */
import { useState } from "preact/hooks";
import { postAction } from "../../api/client";
import { ranges } from "../../format";
import { useShell } from "../../shell/context";
import { isOffered } from "../../state/commands";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { ascending, confirmedIds, isSame } from "./vehicles";

interface Props {
  /** Vehicles that are proposed, or what an operator has made of that. */
  chosen: readonly number[];
  onChange(chosen: readonly number[]): void;
  /** The station has taken over what was chosen. */
  onConfirmed(chosen: readonly number[]): void;
}

export function VehicleChoice({ chosen, onChange, onConfirmed }: Props) {
  const { state, isConnected, mayCommand, asked } = useShell();
  const { mission } = state;
  const [refusal, setRefusal] = useState<string | null>(null);
  if (mission === null || mission.vehicles.length === 0) return null;
  const confirmed = confirmedIds(mission.vehicles);
  // Shown before the sign-in, too: the button below must not move when a press on it signs in.
  const isOpen = (mayCommand || asked !== null) && isConnected && isOffered("choose", mission, new Set());
  const isNew = chosen.length > 0 && !isSame(chosen, confirmed);
  const confirm = async (): Promise<void> => {
    const answer = await postAction({ action: "choose", vehicleIds: chosen });
    setRefusal(answer.ok ? null : answer.message);
    if (answer.ok) onConfirmed(chosen);
  };
  const toggle = (id: number, isChosen: boolean): void =>
    onChange(ascending(isChosen ? [...chosen, id] : chosen.filter((one) => one !== id)));
  return (
    <Panel title={texts.prepare.fleet} testId="vehicle-choice" class="vehicle-choice">
      <p data-testid="vehicles-confirmed" class={confirmed.length === 0 ? "is-bad" : undefined}>
        {confirmed.length === 0 ? texts.prepare.unconfirmed : texts.prepare.confirmed(ranges(confirmed))}
      </p>
      {isOpen && (
        <form
          class="form"
          onSubmit={(event) => {
            event.preventDefault();
            void confirm();
          }}
        >
          <VehicleBoxes
            ids={ascending(mission.vehicles.map((vehicle) => vehicle.vehicle_id))}
            chosen={chosen}
            isDisabled={!mayCommand}
            onToggle={toggle}
          />
          <button type="submit" data-testid="confirm-vehicles" disabled={!isNew || !mayCommand}>
            {texts.prepare.confirm(chosen.length)}
          </button>
          <p class="is-bad" role="alert">
            {refusal}
          </p>
        </form>
      )}
    </Panel>
  );
}

const STEPS: Readonly<Record<string, number>> = { ArrowUp: -1, ArrowLeft: -1, ArrowDown: 1, ArrowRight: 1 };

interface BoxesProps {
  ids: readonly number[];
  chosen: readonly number[];
  isDisabled: boolean;
  onToggle(id: number, isChosen: boolean): void;
}

/** One box per vehicle: the Tab key stops once, and the arrow keys move from box to box. */
function VehicleBoxes({ ids, chosen, isDisabled, onToggle }: BoxesProps) {
  const [visited, setVisited] = useState<number | null>(null);
  const stop = ids.find((id) => id === visited) ?? ids[0];
  const moveFocus = (event: KeyboardEvent & { currentTarget: HTMLElement }): void => {
    const step = STEPS[event.key];
    if (step === undefined) return;
    const boxes = [...event.currentTarget.querySelectorAll("input")];
    event.preventDefault();
    boxes[boxes.findIndex((box) => box === event.target) + step]?.focus();
  };
  return (
    <div class="vehicle-boxes" role="group" aria-label={texts.prepare.fleet} onKeyDown={moveFocus}>
      {ids.map((id) => (
        <label key={id}>
          <input
            type="checkbox"
            data-testid={`choose-${id}`}
            tabIndex={id === stop ? 0 : -1}
            checked={chosen.includes(id)}
            disabled={isDisabled}
            onFocus={() => setVisited(id)}
            onChange={(event) => onToggle(id, event.currentTarget.checked)}
          />
          {id}
        </label>
      ))}
    </div>
  );
}
