import type { Map as MapLibreMap } from "maplibre-gl";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { drawGesturesCoarsely } from "../src/map/gesture_drawing";

/** As much of a map as gestures need: what it is drawn by, whether it moves, and the resolutions that were set. */
class DrawnMap {
  readonly ratios: number[] = [];
  readonly container = new EventTarget();
  isMoved = false;
  constructor(private readonly renderer: string) {}
  getCanvasContainer = () => this.container;
  getCanvas = () => ({
    getContext: () => ({
      getExtension: () => ({ UNMASKED_RENDERER_WEBGL: 1 }),
      getParameter: () => this.renderer,
    }),
  });
  isMoving = () => this.isMoved;
  setPixelRatio = (ratio: number) => this.ratios.push(ratio);
}

const drawnBy = (renderer: string): { map: DrawnMap; end: () => void } => {
  const map = new DrawnMap(renderer);
  return { map, end: drawGesturesCoarsely(map as unknown as MapLibreMap) };
};
const SOFTWARE = "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)";

beforeEach(() => {
  vi.useFakeTimers();
  const page = Object.assign(new EventTarget(), { setTimeout, clearTimeout, devicePixelRatio: 2 });
  vi.stubGlobal("window", page);
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test("a gesture is drawn coarsely until the map rests", () => {
  const { map } = drawnBy(SOFTWARE);
  map.container.dispatchEvent(new Event("pointerdown"));
  expect(map.ratios).toEqual([1.4]);
  vi.advanceTimersByTime(10_000);
  window.dispatchEvent(new Event("pointerup"));
  map.isMoved = true;
  vi.advanceTimersByTime(10_000);
  expect(map.ratios).toEqual([1.4]);
  map.isMoved = false;
  vi.advanceTimersByTime(1_000);
  expect(map.ratios).toEqual([1.4, 2]);
});

test("turns of the wheel that follow each other change the resolution once", () => {
  const { map } = drawnBy("llvmpipe (LLVM 15.0.6, 256 bits)");
  for (let turn = 0; turn < 5; turn++) {
    map.container.dispatchEvent(new Event("wheel"));
    vi.advanceTimersByTime(100);
  }
  vi.advanceTimersByTime(1_000);
  expect(map.ratios).toEqual([1.4, 2]);
});

test("a graphics card draws all pixels at any time", () => {
  const { map } = drawnBy("ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)");
  map.container.dispatchEvent(new Event("pointerdown"));
  map.container.dispatchEvent(new Event("wheel"));
  vi.advanceTimersByTime(1_000);
  expect(map.ratios).toEqual([]);
});

test("a map that has gone is not drawn again", () => {
  const { map, end } = drawnBy(SOFTWARE);
  map.container.dispatchEvent(new Event("wheel"));
  end();
  map.container.dispatchEvent(new Event("wheel"));
  vi.advanceTimersByTime(1_000);
  expect(map.ratios).toEqual([1.4]);
});
