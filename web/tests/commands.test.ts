import { expect, test } from "vitest";
import { isOffered, makeCommand, makeFocusCommand, targets } from "../src/state/commands";
import { mission, vehicle } from "./samples";

test("the selection is the scope, but start and abort concern all", () => {
  const selected = new Set([10, 3]);
  expect(targets("hold", selected)).toEqual([3, 10]);
  expect(targets("hold", new Set())).toBeNull();
  expect(targets("start", selected)).toBeNull();
  expect(targets("abort", selected)).toBeNull();
});

test("a command names its scope", () => {
  const fleet = mission({ vehicles: [1, 4, 7, 9].map((id) => vehicle(id)) });
  expect(makeCommand("hold", fleet, new Set([7, 1, 4])).label).toBe("Hold 3 of 4: 1, 4, 7");
  expect(makeCommand("return", fleet, new Set()).label).toBe("Return all 4");
  expect(makeCommand("join", fleet, new Set()).label).toBe("Join all mission vehicles on the ground");
  const swarm = mission({ vehicles: [1, 4, 7].map((id) => vehicle(id, { takes_part: id !== 4 })) });
  expect(makeCommand("start", swarm, new Set([4])).label).toBe("Launch vehicles 1, 7");
  expect(makeCommand("abort", fleet, new Set([1])).label).toBe("Abort the mission");
});

test("only what the service allows is offered", () => {
  expect(isOffered("hold", mission(), new Set())).toBe(true);
  expect(isOffered("start", mission(), new Set())).toBe(false);
  expect(isOffered("hold", null, new Set())).toBe(false);
});

test("a single vehicle can be paused while the mission is", () => {
  const paused = mission({ suspension: "paused", allowed_actions: ["resume", "hold"] });
  expect(isOffered("pause", paused, new Set())).toBe(false);
  expect(isOffered("pause", paused, new Set([1]))).toBe(true);
});

test("the focal plane is the mission's, whatever is selected; zero is a height", () => {
  expect(makeFocusCommand(0)).toEqual({
    action: "focus",
    vehicleIds: null,
    focalHeight_m: 0,
    label: "Set the mission focal plane to 0.0\u202fm",
  });
  expect(makeFocusCommand(null)).toMatchObject({ focalHeight_m: null });
});
