/** Hook for the current size of an element. */
import { useEffect, useState } from "preact/hooks";

export interface Size {
  readonly width_px: number;
  readonly height_px: number;
}

/** Inner size without borders; null before the element is laid out. */
export function useSize(element: { readonly current: HTMLElement | null }): Size | null {
  const [size, setSize] = useState<Size | null>(null);
  useEffect(() => {
    const observed = element.current;
    if (observed === null) return undefined;
    const observer = new ResizeObserver(() =>
      setSize({ width_px: observed.clientWidth, height_px: observed.clientHeight }),
    );
    observer.observe(observed);
    return () => observer.disconnect();
  }, []);
  return size;
}
