import type { Map as MapLibreMap } from "maplibre-gl";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { gatherDrawings } from "../src/map/gathered_drawing";

/** As much of a map as drawing needs: how often it was drawn, whether it moves, and who wants to know that it has moved. */
class DrawnMap {
  readonly container = new EventTarget();
  readonly movers = new Set<() => void>();
  drawings = 0;
  isMoved = false;
  getCanvasContainer = () => this.container;
  isMoving = () => this.isMoved;
  triggerRepaint = () => {
    this.drawings++;
  };
  on = (_: string, mover: () => void) => this.movers.add(mover);
  off = (_: string, mover: () => void) => this.movers.delete(mover);
  /** Have the layers change a few times, a moment apart. */
  change(times: number): void {
    for (let time = 0; time < times; time++) {
      this.triggerRepaint();
      vi.advanceTimersByTime(16);
    }
  }
}

const gathered = (): { map: DrawnMap; end: () => void } => {
  const map = new DrawnMap();
  return { map, end: gatherDrawings(map as unknown as MapLibreMap) };
};

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("window", { setTimeout, clearTimeout });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("layers that change at about the same time are drawn once", () => {
  const { map } = gathered();
  map.change(4);
  vi.advanceTimersByTime(1_000);
  expect(map.drawings).toBe(1);
  map.change(1);
  vi.advanceTimersByTime(1_000);
  expect(map.drawings).toBe(2);
});

test("a map that moves is drawn at once, whoever moves it", () => {
  const { map } = gathered();
  map.isMoved = true;
  map.change(4);
  expect(map.drawings).toBe(4);
  map.isMoved = false;
  for (const mover of map.movers) mover();
  expect(map.drawings).toBe(5);
});

test("a map that is touched is drawn at once, and gathers again at rest", () => {
  const { map } = gathered();
  map.container.dispatchEvent(new Event("wheel"));
  map.change(2);
  expect(map.drawings).toBe(2);
  vi.advanceTimersByTime(1_000);
  map.change(2);
  vi.advanceTimersByTime(1_000);
  expect(map.drawings).toBe(3);
});

test("a map that has gone is not drawn again", () => {
  const { map, end } = gathered();
  map.change(1);
  end();
  vi.advanceTimersByTime(1_000);
  expect(map.drawings).toBe(0);
  expect(map.movers.size).toBe(0);
});
