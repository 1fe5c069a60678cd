/** Hook that limits how often a displayed value changes; the latest value is always shown in the end. */
import { useEffect, useRef, useState } from "preact/hooks";

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
