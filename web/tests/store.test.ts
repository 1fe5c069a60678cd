import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { PageMessage } from "../src/api/socket";
import { Store } from "../src/state/store";

const news = (seq: number): PageMessage => ({ kind: "plan", operator: "", seq, utc_s: 0 });

beforeEach(() => vi.useFakeTimers({ toFake: ["performance", "setTimeout", "clearTimeout"] }));
afterEach(() => vi.useRealTimers());

test("news after a quiet time is told at once, a stream of it a few times per second, the last of it always", () => {
  const store = new Store();
  const told: number[] = [];
  store.subscribe((state) => told.push(state.planRevision));
  store.receive(news(1));
  vi.advanceTimersByTime(1);
  expect(told).toEqual([1]);
  for (let seq = 2; seq <= 101; seq++) {
    store.receive(news(seq));
    vi.advanceTimersByTime(10);
  }
  expect(told.length).toBeGreaterThan(3);
  expect(told.length).toBeLessThan(9);
  vi.advanceTimersByTime(300);
  expect(told.at(-1)).toBe(101);
  const { length } = told;
  vi.advanceTimersByTime(5000);
  expect(told).toHaveLength(length);
});
