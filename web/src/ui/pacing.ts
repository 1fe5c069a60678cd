/** Hooks that slow down values which change often. */
import { useEffect, useRef, useState } from "preact/hooks";

/** The value, changed at most once per interval; the latest one is always shown in the end. */
export function useAtMostEvery<T>(value: T, interval_ms: number): T {
  const [shown, setShown] = useState(value);
  const shownAtMs = useRef(-Infinity);
  useEffect(() => {
    const wait_ms = Math.max(0, shownAtMs.current + interval_ms - performance.now());
    const timer = setTimeout(() => {
      shownAtMs.current = performance.now();
      setShown(value);
    }, wait_ms);
    return () => clearTimeout(timer);
  }, [value]);
  return shown;
}

/** Whether a value that an operator moves has come to rest: true at first, and after it has stayed for some time. */
export function useResting(value: unknown, after_ms: number): boolean {
  const [rested, setRested] = useState(value);
  useEffect(() => {
    const timer = setTimeout(() => setRested(value), after_ms);
    return () => clearTimeout(timer);
  }, [value, after_ms]);
  return Object.is(rested, value);
}
