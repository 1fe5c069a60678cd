/** Selection of a time range in a chart by finger, since uPlot itself follows mice only. */
import type uPlot from "uplot";

/** Returns a function that stops it. Vertical movements scroll the page as usual. */
export function selectByFinger(plot: uPlot): () => void {
  const { over } = plot;
  let from_px: number | null = null;
  const place = (event: PointerEvent): number => {
    const box = over.getBoundingClientRect();
    return Math.max(0, Math.min(box.width, event.clientX - box.left));
  };
  const select = (event: PointerEvent, isDone: boolean): void => {
    if (from_px === null) return;
    const to_px = place(event);
    const [left, width] = [Math.min(from_px, to_px), Math.abs(to_px - from_px)];
    plot.setSelect({ left, width, top: 0, height: over.clientHeight }, isDone);
  };
  const on: { [Name in keyof HTMLElementEventMap]?: (event: PointerEvent) => void } = {
    pointerdown(event) {
      if (event.pointerType === "touch" && event.isPrimary) from_px = place(event);
    },
    pointermove: (event) => select(event, false),
    pointerup(event) {
      select(event, true);
      from_px = null;
    },
    pointercancel() {
      if (from_px !== null) plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
      from_px = null;
    },
  };
  const listeners = Object.entries(on) as [string, (event: Event) => void][];
  for (const [name, listener] of listeners) over.addEventListener(name, listener);
  return () => {
    for (const [name, listener] of listeners) over.removeEventListener(name, listener);
  };
}
