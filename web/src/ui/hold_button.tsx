/** A button that has to be held, by pointer or by key, so that a slip of a finger neither starts nor lands a swarm. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { CONFIRM_AFTER_MS, HoldPress } from "./hold_press";

interface Props {
  label: string;
  testId: string;
  class?: string;
  isDisabled?: boolean;
  /** Id of the element that says what it does. */
  describedBy?: string;
  onConfirm(): void;
  /** The button is no longer held after it has confirmed. */
  onLetGo?(): void;
}

const isPressing = (event: KeyboardEvent): boolean => event.key === "Enter" || event.key === " ";

export function HoldButton({ label, testId, class: extra = "", isDisabled, describedBy, onConfirm, onLetGo }: Props) {
  const [isPressed, setPressed] = useState(false);
  const latest = useRef({ onConfirm, onLetGo });
  latest.current = { onConfirm, onLetGo };
  const press = useMemo(
    () =>
      new HoldPress({
        onPressed: setPressed,
        onConfirm: () => latest.current.onConfirm(),
        onLetGo: () => latest.current.onLetGo?.(),
      }),
    [],
  );
  const end = (): void => press.end();
  useEffect(() => end, []);
  return (
    <button
      type="button"
      class={`danger hold-button ${extra} ${isPressed ? "is-pressed" : ""}`}
      style={{ "--confirm-after": `${CONFIRM_AFTER_MS}ms` }}
      data-testid={testId}
      disabled={isDisabled}
      aria-describedby={describedBy}
      onPointerDown={(event) => press.beginByPointer(event.currentTarget, event)}
      onPointerMove={(event) => press.move(event)}
      onPointerUp={(event) => press.release(event)}
      onPointerCancel={end}
      onLostPointerCapture={end}
      onBlur={end}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => isPressing(event) && press.begin(event)}
      onKeyUp={(event) => isPressing(event) && press.release(event)}
    >
      {label}
    </button>
  );
}
