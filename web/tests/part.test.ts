/** Parts of the page that are loaded on their own. */
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Part } from "../src/ui/part";

beforeEach(() => {
  vi.useFakeTimers();
  vi.spyOn(console, "warn").mockImplementation(() => undefined);
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

test("a part is loaded once, and stays", async () => {
  const fetch = vi.fn(async () => "view");
  const part = new Part(fetch);
  expect(part.now).toBeNull();
  expect(await Promise.all([part.load(), part.load()])).toEqual(["view", "view"]);
  expect(await part.load()).toBe("view");
  expect(part.now).toBe("view");
  expect(fetch).toHaveBeenCalledTimes(1);
});

test("a station that does not answer is asked again", async () => {
  const fetch = vi.fn(async () => "view").mockRejectedValueOnce(new TypeError("no network"));
  const part = new Part(fetch);
  const loading = part.load();
  await vi.runAllTimersAsync();
  expect(await loading).toBe("view");
  expect(fetch).toHaveBeenCalledTimes(2);
});
