/** A button that has to be kept pressed, by pointer or by key: no slip of a finger starts or lands a swarm. */
import { useEffect, useRef, useState } from "preact/hooks";

export const CONFIRM_AFTER_MS = 800;

interface Props {
  label: string;
  testId: string;
  onConfirm(): void;
}

const isPressing = (event: KeyboardEvent): boolean => event.key === "Enter" || event.key === " ";

export function HoldButton({ label, testId, onConfirm }: Props) {
  const [isPressed, setPressed] = useState(false);
  const timer = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const release = (): void => {
    clearTimeout(timer.current);
    timer.current = undefined;
    setPressed(false);
  };
  const press = (): void => {
    if (timer.current !== undefined) return;
    setPressed(true);
    timer.current = setTimeout(() => {
      release();
      onConfirm();
    }, CONFIRM_AFTER_MS);
  };
  useEffect(() => () => clearTimeout(timer.current), []);
  return (
    <button
      type="button"
      class={`danger hold-button ${isPressed ? "is-pressed" : ""}`}
      style={{ "--confirm-after": `${CONFIRM_AFTER_MS}ms` }}
      data-testid={testId}
      onPointerDown={press}
      onPointerUp={release}
      onPointerLeave={release}
      onPointerCancel={release}
      onBlur={release}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => isPressing(event) && press()}
      onKeyUp={(event) => isPressing(event) && release()}
    >
      {label}
    </button>
  );
}
