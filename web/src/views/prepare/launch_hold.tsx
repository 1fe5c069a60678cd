/**
 * The launch: a button that has to be held, beside what it starts. Where the vehicles are not confirmed yet, it confirms
 * them first, and launches when their checks have passed, for as long as it is held.
 */
import { useEffect, useRef, useState } from "preact/hooks";
import { postAction } from "../../api/client";
import type { Mission, PreflightCheck } from "../../api/types";
import { ranges } from "../../format";
import { useShell } from "../../shell/context";
import { isOffered } from "../../state/commands";
import { texts } from "../../texts";
import { HoldButton } from "../../ui/hold_button";
import { blockersOf, warningsOf, withoutConfirmation } from "./checks";
import { confirmedIds, isProposal, isSame } from "./vehicles";

/** A press that lasts longer than this is no longer taken for attention. */
const CHECKED_WITHIN_MS = 20_000;
const CONSEQUENCE_ID = "launch-consequence";

interface Props {
  mission: Mission;
  checks: readonly PreflightCheck[];
  /** Vehicles that are to fly. */
  vehicles: readonly number[];
  /** The station has taken over the vehicles. */
  onConfirmed(vehicles: readonly number[]): void;
}

/** A launch that waits for the checks of vehicles just confirmed. */
interface Waiting {
  readonly vehicles: readonly number[];
  /** Keys of the warnings that the operator could read before. */
  readonly warnings: ReadonlySet<string>;
}

export function LaunchHold({ mission, checks, vehicles, onConfirmed }: Props) {
  const { isConnected, commands, operator, asked } = useShell();
  const [waiting, setWaiting] = useState<Waiting | null>(null);
  const [note, setNote] = useState("");
  const group = useRef<HTMLDivElement>(null);
  const { prepare } = texts;
  const step = nextStep(mission, checks, vehicles);
  const isNameMissing = asked !== null && (asked.name === "" || asked.refusal !== "");
  const isAvailable = isConnected && step !== null && !isNameMissing;

  const confirm = async (): Promise<void> => {
    const started: Waiting = { vehicles, warnings: warningsOf(checks) };
    setWaiting(started);
    const answer = await postAction({ action: "choose", vehicleIds: vehicles });
    if (answer.ok) return onConfirmed(vehicles);
    setNote(answer.message);
    setWaiting(null);
  };
  const begin = (): void => {
    setNote("");
    // The press has made the name leave its field: without an answer by now, nothing is launched under any name.
    if (asked !== null) {
      asked.leave();
      setNote(prepare.notSignedIn);
    } else if (step === "launch") commands.launch();
    else if (step === "confirm") void confirm();
  };
  const stop = (reason: string): void => {
    setWaiting(null);
    setNote(reason);
  };

  useEffect(() => {
    if (waiting === null) return;
    if (!isConnected) stop(texts.requests.noConnection);
    else if (isOffered("start", mission, new Set()) && isSame(confirmedIds(mission.vehicles), waiting.vehicles)) {
      const isNew = [...warningsOf(checks)].some((key) => !waiting.warnings.has(key));
      stop(isNew ? texts.prepare.newWarnings : "");
      if (!isNew) commands.launch();
    }
  });
  useEffect(() => {
    if (waiting === null) return undefined;
    const timer = setTimeout(() => stop(texts.prepare.checksLast), CHECKED_WITHIN_MS);
    return () => clearTimeout(timer);
  }, [waiting]);
  useEffect(() => setNote(""), [operator]);
  useEffect(() => {
    // Who comes by a key or from signing in launches next; who works on this page keeps the focus.
    const { activeElement } = document;
    const isFree = activeElement === document.body || activeElement?.matches("main") === true;
    if (isAvailable && isFree && document.querySelector("dialog[open]") === null) {
      group.current?.focus({ preventScroll: true });
    }
  }, [isAvailable, operator]);

  const ids = ranges(vehicles);
  const label = waiting ? prepare.keepHolding : step === "confirm" ? prepare.holdToConfirm(ids) : prepare.holdTo(ids);
  return (
    <div ref={group} class="launch-hold" role="group" tabIndex={-1} aria-label={prepare.launch}>
      <p id={CONSEQUENCE_ID} class="small" data-testid="launch-consequence">
        {step !== null && isNameMissing && `${prepare.nameFirst} `}
        {step !== null && `${prepare.flies(ids, asked?.name ?? operator)} ${texts.actions.consequence.start}`}
        {step === "confirm" && ` ${prepare.checkedFirst}`}
      </p>
      <p class="is-bad" role="alert" data-testid="launch-note">
        {note}
      </p>
      <HoldButton
        label={label}
        testId="launch"
        class="launch-button"
        isDisabled={!isAvailable && waiting === null}
        describedBy={CONSEQUENCE_ID}
        onConfirm={begin}
        onLetGo={() => setWaiting(null)}
      />
    </div>
  );
}

/** What the button does now: launch, confirm the vehicles first, or nothing. */
function nextStep(
  mission: Mission,
  checks: readonly PreflightCheck[],
  vehicles: readonly number[],
): "launch" | "confirm" | null {
  if (isSame(vehicles, confirmedIds(mission.vehicles))) return isOffered("start", mission, new Set()) ? "launch" : null;
  const isClear = checks.length > 0 && blockersOf(withoutConfirmation(checks, vehicles)).length === 0;
  return isClear && isProposal(mission, vehicles) && isOffered("choose", mission, new Set()) ? "confirm" : null;
}
