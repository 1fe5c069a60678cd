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
  const press = useRef<{ atMs: number; timer: ReturnType<typeof setTimeout> } | null>(null);

  const end = (): void => {
    clearTimeout(press.current?.timer);
    press.current = null;
    setPressed(false);
  };
  const confirm = (): void => {
    end();
    onConfirm();
  };
  const begin = ({ timeStamp }: Event): void => {
    if (press.current !== null) return;
    setPressed(true);
    press.current = { atMs: timeStamp, timer: setTimeout(confirm, CONFIRM_AFTER_MS) };
  };
  const release = ({ timeStamp }: Event): void => {
    // A page that is busy may hear of the release before its own timer: what counts is how long it was pressed.
    if (press.current !== null && timeStamp - press.current.atMs >= CONFIRM_AFTER_MS) confirm();
    else end();
  };
  useEffect(() => () => clearTimeout(press.current?.timer), []);
  return (
    <button
      type="button"
      class={`danger hold-button ${isPressed ? "is-pressed" : ""}`}
      style={{ "--confirm-after": `${CONFIRM_AFTER_MS}ms` }}
      data-testid={testId}
      onPointerDown={begin}
      onPointerUp={release}
      onPointerLeave={end}
      onPointerCancel={end}
      onBlur={end}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => isPressing(event) && begin(event)}
      onKeyUp={(event) => isPressing(event) && release(event)}
    >
      {label}
    </button>
  );
}
