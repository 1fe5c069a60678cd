/** Hook for the keys Ctrl+Z and Ctrl+Shift+Z, except in text fields, which undo their own typing. */
import { useEffect, useRef } from "preact/hooks";
import { focusOf } from "../../shell/keys";

export interface Undo {
  readonly canUndo: boolean;
  readonly canRedo: boolean;
  undo(): void;
  redo(): void;
}

const isMeant = (target: EventTarget | null): boolean =>
  target instanceof HTMLSelectElement || focusOf(target, document) === "page";

export function useUndoKeys(actions: Undo, isOn: boolean): void {
  const current = useRef({ actions, isOn });
  current.current = { actions, isOn };
  useEffect(() => {
    const listen = (event: KeyboardEvent): void => {
      const { actions: now, isOn: isListening } = current.current;
      const isUndoKey = event.key.toLowerCase() === "z" && (event.ctrlKey || event.metaKey) && !event.altKey;
      if (!isUndoKey || !isListening || !isMeant(event.target)) return;
      event.preventDefault();
      if (event.shiftKey) now.redo();
      else now.undo();
    };
    window.addEventListener("keydown", listen);
    return () => window.removeEventListener("keydown", listen);
  }, []);
}
