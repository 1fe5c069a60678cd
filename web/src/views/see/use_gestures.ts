/** Dragging, pinching, wheel and tapping for images that can be moved and zoomed. */
import { useEffect, useRef } from "preact/hooks";
import type { ScreenPoint } from "./viewport";

export interface Gestures {
  /** Moved by pixels, then scaled by a factor about a point; two fingers do both at once. */
  onMove(by: ScreenPoint, factor: number, at: ScreenPoint): void;
  onTap(at: ScreenPoint): void;
  /** Null when the pointer has left the element. */
  onHover(at: ScreenPoint | null): void;
}

/** Longest travel of a pointer that counts as a tap. */
const TAP_RADIUS_PX = 5;
const ZOOM_PER_WHEEL_PX = 1.0015;

export function useGestures(element: { readonly current: HTMLElement | null }, gestures: Gestures): void {
  const latest = useRef(gestures);
  latest.current = gestures;
  useEffect(() => {
    const target = element.current;
    if (target === null) return undefined;
    const pointers = new Map<number, ScreenPoint>();
    let travelled_px = 0;
    const place = (event: MouseEvent): ScreenPoint => {
      const box = target.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    const on: { [Name in keyof HTMLElementEventMap]?: (event: HTMLElementEventMap[Name]) => void } = {
      pointerdown(event) {
        if (event.button !== 0) return;
        target.setPointerCapture(event.pointerId);
        // A second finger makes it a pinch, which is never a tap.
        travelled_px = pointers.size === 0 ? 0 : Infinity;
        pointers.set(event.pointerId, place(event));
      },
      pointermove(event) {
        const now = place(event);
        latest.current.onHover(now);
        const before = pointers.get(event.pointerId);
        if (before === undefined) return;
        const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
        pointers.set(event.pointerId, now);
        if (other === undefined) {
          travelled_px += distance(before, now);
          if (travelled_px > TAP_RADIUS_PX) latest.current.onMove([now[0] - before[0], now[1] - before[1]], 1, now);
        } else {
          const middle: ScreenPoint = [(now[0] + other[0]) / 2, (now[1] + other[1]) / 2];
          const by: ScreenPoint = [(now[0] - before[0]) / 2, (now[1] - before[1]) / 2];
          latest.current.onMove(by, distance(now, other) / Math.max(1, distance(before, other)), middle);
        }
      },
      pointerup(event) {
        if (pointers.delete(event.pointerId) && travelled_px <= TAP_RADIUS_PX) latest.current.onTap(place(event));
      },
      pointercancel: (event) => void pointers.delete(event.pointerId),
      pointerleave: () => latest.current.onHover(null),
      wheel(event) {
        event.preventDefault();
        latest.current.onMove([0, 0], ZOOM_PER_WHEEL_PX ** -event.deltaY, place(event));
      },
    };
    const listeners = Object.entries(on) as [string, (event: Event) => void][];
    for (const [name, listener] of listeners) target.addEventListener(name, listener, { passive: false });
    return () => {
      for (const [name, listener] of listeners) target.removeEventListener(name, listener);
    };
  }, []);
}

const distance = (a: ScreenPoint, b: ScreenPoint): number => Math.hypot(a[0] - b[0], a[1] - b[1]);
