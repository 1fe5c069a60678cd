import { expect, test } from "vitest";
import { Newest } from "../src/api/newest";

test("sends one request at a time, and of those that wait only the newest", async () => {
  const sent: number[] = [];
  const answer: (() => void)[] = [];
  const newest = new Newest<number>((query) => {
    sent.push(query);
    return new Promise((resolve) => answer.push(resolve));
  });
  const settle = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));
  [1, 2, 3, 4].forEach((query) => newest.ask(query));
  expect(sent).toEqual([1]);
  answer.shift()?.();
  await settle();
  expect(sent).toEqual([1, 4]);
  newest.ask(5);
  newest.forget();
  answer.shift()?.();
  await settle();
  expect(sent).toEqual([1, 4]);
  newest.ask(6);
  expect(sent).toEqual([1, 4, 6]);
});
