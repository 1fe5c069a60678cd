/** Hook for the keys of the page. */
import { useEffect, useRef } from "preact/hooks";
import { focusOf, type KeyCommand, keyCommand } from "./keys";

/** Call `onCommand` for every keystroke with a meaning, wherever the focus is. */
export function useKeys(onCommand: (command: KeyCommand) => void): void {
  const handler = useRef(onCommand);
  handler.current = onCommand;
  useEffect(() => {
    const listen = (event: KeyboardEvent): void => {
      const command = keyCommand(event, focusOf(event.target, document));
      if (command !== null) handler.current(command);
    };
    // In the capture phase, before any element handles the keystroke.
    window.addEventListener("keydown", listen, { capture: true });
    return () => window.removeEventListener("keydown", listen, { capture: true });
  }, []);
}
