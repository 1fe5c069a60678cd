/** Hook for the state of the store. */
import { useEffect, useState } from "preact/hooks";
import type { State } from "../state/state";
import type { Store } from "../state/store";

/** Interval of updates while no data arrive, so that ages advance. */
const AGEING_INTERVAL_MS = 500;

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
