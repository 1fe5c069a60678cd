/** Hooks of the page: its route, its keys, and the state of the store. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { State } from "../state/state";
import type { Store } from "../state/store";
import { focusOf, type KeyCommand, keyCommand, pressesAgain } from "./keys";
import { parseRoute, type Route, surveyRoute } from "./route";

/** Interval of updates while no data arrive, so that ages advance. */
const AGEING_INTERVAL_MS = 500;

/** The current route; the back button of the browser works. */
export function useRoute(isSurvey: boolean): Route {
  const [route, setRoute] = useState(() => parseRoute(location.hash));
  useEffect(() => {
    const follow = (): void => setRoute(parseRoute(location.hash));
    window.addEventListener("hashchange", follow);
    return () => window.removeEventListener("hashchange", follow);
  }, []);
  return isSurvey ? surveyRoute(route) : route;
}

/** Call `onCommand` for every keystroke with a meaning, wherever the focus is. */
export function useKeys(onCommand: (command: KeyCommand) => void): void {
  const handler = useRef(onCommand);
  handler.current = onCommand;
  useEffect(() => {
    const listen = (event: KeyboardEvent): void => {
      if (pressesAgain(event)) event.preventDefault();
      const command = keyCommand(event, focusOf(event.target, document));
      if (command !== null) handler.current(command);
    };
    // In the capture phase, before any element handles the keystroke.
    window.addEventListener("keydown", listen, { capture: true });
    return () => window.removeEventListener("keydown", listen, { capture: true });
  }, []);
}

/** The state of the store, renewed as it ages. */
export function useStoreState(store: Store): State {
  const [state, setState] = useState(store.state);
  const [, setTick] = useState(0);
  useEffect(() => store.subscribe(setState), [store]);
  useEffect(() => {
    const timer = setInterval(() => setTick((tick) => tick + 1), AGEING_INTERVAL_MS);
    return () => clearInterval(timer);
  }, []);
  return state;
}
