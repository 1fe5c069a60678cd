/** The store's state in a component. */
import { useEffect, useState } from "preact/hooks";
import type { State } from "../state/state";
import type { Store } from "../state/store";

/** Ages go on counting while no data comes. */
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
