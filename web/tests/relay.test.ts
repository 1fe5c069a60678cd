import { describe, expect, test } from "vitest";
import { relayFacts } from "../src/panels/relay";
import { isOffered } from "../src/state/commands";
import { mission, vehicle } from "./samples";

describe("the facts about the relay", () => {
  test("name who leaves next, when each leaves, and who waits on the ground", () => {
    const facts = relayFacts([
      vehicle(1, { leaves_in_s: 312 }),
      vehicle(2, { leaves_in_s: 65 }),
      vehicle(3, { leaves_in_s: -4 }),
      vehicle(4),
      vehicle(7, { relay_ready: true }),
      vehicle(8, { relay_ready: false }),
    ]);
    expect(facts).toEqual([
      ["Leaves next: vehicle 3", "now"],
      ["Vehicle 2", "in 01:05"],
      ["Vehicle 1", "in 05:12"],
      ["Vehicle 7", "ready to take off"],
      ["Vehicle 8", "on the ground: not confirmed as ready"],
    ]);
  });

  test("are none where no battery is known and no relay is flown", () => {
    expect(relayFacts([vehicle(1), vehicle(2)])).toEqual([]);
  });
});

test("only vehicles that are named and on the ground can be confirmed as ready", () => {
  const grounded = vehicle(7, { armed: false, landed: "on_ground", task: "landed" });
  const shown = mission({ vehicles: [vehicle(1), grounded], allowed_actions: ["ready"] });
  expect(isOffered("ready", shown, new Set([7]))).toBe(true);
  expect(isOffered("ready", shown, new Set([1, 7]))).toBe(false);
  expect(isOffered("ready", shown, new Set())).toBe(false);
});
