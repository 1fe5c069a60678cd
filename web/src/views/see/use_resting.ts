/** Hook that reports when a value that an operator moves has come to rest. */
import { useEffect, useState } from "preact/hooks";

/** True at first, and whenever the value has not changed for the given time. */
export function useResting(value: unknown, after_ms: number): boolean {
  const [rested, setRested] = useState(value);
  useEffect(() => {
    const timer = setTimeout(() => setRested(value), after_ms);
    return () => clearTimeout(timer);
  }, [value, after_ms]);
  return Object.is(rested, value);
}
