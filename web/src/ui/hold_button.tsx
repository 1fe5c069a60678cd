/** A button that has to be held, by pointer or by key, so that a slip of a finger neither starts nor lands a swarm. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { CONFIRM_AFTER_MS, HoldPress } from "./hold_press";

interface Props {
  label: string;
  testId: string;
  onConfirm(): void;
}

const isPressing = (event: KeyboardEvent): boolean => event.key === "Enter" || event.key === " ";

export function HoldButton({ label, testId, onConfirm }: Props) {
  const [isPressed, setPressed] = useState(false);
  const confirm = useRef(onConfirm);
  confirm.current = onConfirm;
  const press = useMemo(() => new HoldPress({ onPressed: setPressed, onConfirm: () => confirm.current() }), []);
  const end = (): void => press.end();
  useEffect(() => end, []);
  return (
    <button
      type="button"
      class={`danger hold-button ${isPressed ? "is-pressed" : ""}`}
      style={{ "--confirm-after": `${CONFIRM_AFTER_MS}ms` }}
      data-testid={testId}
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
