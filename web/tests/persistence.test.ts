import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { Answer } from "../src/api/client";
import { untilAnswered } from "../src/api/persistence";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const LOST: Answer<string> = { ok: false, message: "lost" };

/** Requests of which the first ones are lost. */
const losing = (count: number) => {
  const ask = vi.fn(async (): Promise<Answer<string>> =>
    ask.mock.calls.length > count ? { ok: true, value: "here" } : LOST,
  );
  return ask;
};

test("a lost answer is asked for again", async () => {
  const ask = losing(3);
  const answer = untilAnswered(ask, () => true);
  await vi.runAllTimersAsync();
  expect(await answer).toBe("here");
  expect(ask).toHaveBeenCalledTimes(4);
});

test("nothing is asked for once the answer is not wanted, and a late one counts for nothing", async () => {
  let isWanted = true;
  const ask = losing(1);
  const answer = untilAnswered(ask, () => isWanted);
  await vi.advanceTimersByTimeAsync(1);
  isWanted = false;
  await vi.runAllTimersAsync();
  expect(await answer).toBeNull();
  expect(ask).toHaveBeenCalledTimes(1);
});
