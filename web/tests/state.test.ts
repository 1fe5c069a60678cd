import { describe, expect, test } from "vitest";
import { isStale, linkAge_s } from "../src/state/freshness";
import { INITIAL_STATE, reduce, type State } from "../src/state/state";
import type { ServerMessage } from "../src/api/types";
import { mission, position, step, vehicle } from "./samples";

type Hello = Extract<ServerMessage, { kind: "hello" }>;

const hello = (changes: Partial<Hello> = {}): Hello => ({
  kind: "hello",
  seq: 1,
  schema_version: 2,
  mission: mission(),
  steps: [step(1)],
  notices: [],
  pictures: [],
  ...changes,
});
const snapshot = (m = mission()) => ({ kind: "snapshot", seq: 2, utc_s: 0, mission: m }) as const;

describe("reduce", () => {
  test("a hello replaces everything but the trails of the same mission", () => {
    const flown = reduce(INITIAL_STATE, hello(), 0);
    const moved = mission({ vehicles: [vehicle(1, { position: position(50, 0) })] });
    const again = reduce(flown, hello({ mission: moved, steps: [] }), 5);
    expect(again.steps).toEqual([]);
    expect(again.missionAtMs).toBe(5);
    expect(again.trails.get(1)).toEqual([
      [10, 0],
      [50, 0],
    ]);
    const other = reduce(again, hello({ mission: mission({ mission_id: "m2" }) }), 6);
    expect(other.trails.get(1)).toEqual([[10, 0]]);
  });

  test("a hello in mid-connection is a jump: trails begin anew", () => {
    const flown = { ...reduce(INITIAL_STATE, hello(), 0), connection: "open" } as const;
    const moved = mission({ vehicles: [vehicle(1, { position: position(50, 0) })] });
    expect(reduce(flown, hello({ mission: moved }), 5).trails.get(1)).toEqual([[50, 0]]);
  });

  test("notices keep their numbers over a new connection, also where mission time stands still", () => {
    const notice = (text: string) => ({ severity: "warning", text, vehicle_id: null, elapsed_s: 0 }) as const;
    const first = reduce(INITIAL_STATE, hello({ notices: [notice("wind"), notice("wind")] }), 0);
    const more = reduce(first, { kind: "notice", seq: 3, utc_s: 0, notice: notice("rain") }, 0);
    const again = reduce(more, hello({ notices: ["wind", "wind", "rain", "wind"].map(notice) }), 0);
    expect(more.notices.map(({ id, text }) => [id, text])).toEqual([
      [1, "wind"],
      [2, "wind"],
      [3, "rain"],
    ]);
    expect(again.notices.map(({ id }) => id)).toEqual([1, 2, 3, 4]);
  });

  test("trails grow with movement alone and stay bounded", () => {
    let state: State = INITIAL_STATE;
    for (let i = 0; i < 1000; i++) {
      const east_m = i < 500 ? i : 499;
      state = reduce(state, snapshot(mission({ vehicles: [vehicle(1, { position: position(east_m, 0) })] })), i);
    }
    expect(state.trails.get(1)).toHaveLength(240);
    expect(state.trails.get(1)?.at(-1)).toEqual([499, 0]);
  });

  test("vehicles without a position have no trail", () => {
    const state = reduce(INITIAL_STATE, snapshot(mission({ vehicles: [vehicle(1, { position: null })] })), 0);
    expect(state.trails.size).toBe(0);
  });

  test("a step that the hello has brought is not added twice", () => {
    const state = reduce(INITIAL_STATE, hello(), 0);
    expect(reduce(state, { kind: "step", seq: 2, utc_s: 0, step: step(1) }, 0).steps).toHaveLength(1);
    expect(reduce(state, { kind: "step", seq: 2, utc_s: 0, step: step(2) }, 0).steps).toHaveLength(2);
  });

  test("pictures are kept per kind", () => {
    const picture = { kind: "integral", step: 1, url: "/a", corners: [] } as const;
    const state = reduce(
      INITIAL_STATE,
      { kind: "pictures", seq: 2, utc_s: 0, pictures: [{ ...picture, corners: [] }] },
      0,
    );
    const thermal = { kind: "thermal" as const, step: 2, url: "/b", corners: [] };
    const both = reduce(state, { kind: "pictures", seq: 3, utc_s: 0, pictures: [thermal] }, 0);
    expect(Object.keys(both.pictures).sort()).toEqual(["integral", "thermal"]);
  });
});

describe("freshness", () => {
  test("a heartbeat says that nothing has changed, so that ages do not grow", () => {
    const known = reduce(INITIAL_STATE, hello(), 1000);
    expect(reduce(known, { kind: "heartbeat", seq: 1 }, 9000)).toEqual({ ...known, missionAtMs: 9000 });
  });
  test("ages go on while no snapshot comes", () => {
    expect(linkAge_s(vehicle(1), 2)).toBeCloseTo(2.2);
    expect(isStale(vehicle(1), 2)).toBe(false);
    expect(isStale(vehicle(1), 3)).toBe(true);
  });
  test("never heard is stale and has no age", () => {
    expect(linkAge_s(vehicle(1, { link_age_s: null }), 1)).toBeNull();
    expect(isStale(vehicle(1, { link_age_s: null }), 0)).toBe(true);
  });
});
