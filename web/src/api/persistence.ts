/** Repetition of requests without whose answer the page is incomplete. */
import type { Answer } from "./client";
import { backoffMs } from "./socket";

/** Ask until there is an answer; null once the answer is no longer wanted. */
export async function untilAnswered<T>(ask: () => Promise<Answer<T>>, isWanted: () => boolean): Promise<T | null> {
  for (let attempt = 0; isWanted(); attempt += 1) {
    const answer = await ask();
    if (answer.ok) return isWanted() ? answer.value : null;
    await new Promise((resolve) => setTimeout(resolve, backoffMs(attempt)));
  }
  return null;
}
