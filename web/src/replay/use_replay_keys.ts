/** Hook for the keys of the replay, except those that the focused element needs itself. */
import { useEffect, useRef } from "preact/hooks";

/** `handle` returns whether the key had a meaning. */
export function useReplayKeys(handle: (key: string) => boolean): void {
  const handler = useRef(handle);
  handler.current = handle;
  useEffect(() => {
    const listen = (event: KeyboardEvent): void => {
      if (event.ctrlKey || event.metaKey || event.altKey || isNeeded(event.target, event.key)) return;
      if (handler.current(event.key)) event.preventDefault();
    };
    window.addEventListener("keydown", listen);
    return () => window.removeEventListener("keydown", listen);
  }, []);
}

function isNeeded(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement && target.type === "range") return key.startsWith("Arrow");
  if (target.closest("input, select, textarea, dialog, [tabindex]") !== null) return true;
  return key === " " && target.closest("button, a") !== null;
}
