import { describe, expect, test } from "vitest";
import { isSilent, isStale, linkAge_s } from "../src/state/freshness";
import type { PageMessage } from "../src/api/socket";
import { INITIAL_STATE, reduce, type State } from "../src/state/state";
import type { ServerMessage } from "../src/api/types";
import { CAPABILITIES, figures, mission, notice, position, step, vehicle } from "./samples";

type Hello = Extract<ServerMessage, { kind: "hello" }>;

const hello = (changes: Partial<Hello> = {}): Hello => ({
  kind: "hello",
  seq: 1,
  schema_version: 5,
  mission_age_s: 0,
  seen: "m-1/0/0",
  capabilities: CAPABILITIES,
  mission: mission(),
  steps: [figures(1)],
  latest_step: step(1),
  notices: [],
  pictures: [],
  ...changes,
});
const snapshot = (m = mission()) =>
  ({ kind: "snapshot", seq: 2, mission_age_s: 0, seen: "m-1/0/0", utc_s: 0, mission: m }) as const;

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

  test("another mission names the one that was shown before", () => {
    const first = reduce(INITIAL_STATE, hello(), 0);
    expect(first.formerMissionId).toBeNull();
    expect(reduce(first, hello(), 1).formerMissionId).toBeNull();
    const other = reduce(first, hello({ mission: mission({ mission_id: "m2" }) }), 2);
    expect(other.formerMissionId).toBe(first.mission?.mission_id);
    expect(reduce(other, hello({ mission: mission({ mission_id: "m2" }) }), 3).formerMissionId).toBe("m1");
  });

  test("after a pause samples have a gap, in a flight as after a lost connection", () => {
    const at = (elapsed_s: number) => mission({ elapsed_s });
    const flown = reduce(INITIAL_STATE, hello({ mission: at(10) }), 10_000);
    const times = (state: State): number[] => state.samples.map(({ elapsed_s }) => elapsed_s);
    expect(times(reduce(flown, snapshot(at(12)), 12_000))).toEqual([10, 12]);
    expect(times(reduce(flown, snapshot(at(20)), 20_000))).toEqual([10, 15, 20]);
    expect(times(reduce(flown, hello({ mission: at(20) }), 20_000))).toEqual([10, 15, 20]);
  });

  test("a hello in mid-connection is a jump of a replay: trails begin anew", () => {
    const flown = { ...reduce(INITIAL_STATE, hello({ notices: [notice(8, "wind")] }), 0), connection: "open" } as const;
    const vehicles = [vehicle(1, { position: position(50, 0) })];
    const replay = { time_s: 0, duration_s: 9, speed: 1, playing: false };
    const jumped = reduce(flown, hello({ mission: mission({ vehicles, replay }), notices: [notice(1, "start")] }), 5);
    expect(jumped.trails.get(1)).toEqual([[50, 0]]);
    expect(jumped.notices.map(({ notice_id }) => notice_id)).toEqual([1]);
    expect(reduce(flown, hello({ mission: mission({ vehicles }) }), 5).trails.get(1)).toHaveLength(2);
  });

  test("what came while there was no connection is added once; what is no longer kept is counted", () => {
    const ids = ({ notices }: State): number[] => notices.map(({ notice_id }) => notice_id);
    const first = reduce(INITIAL_STATE, hello({ notices: [notice(4, "wind"), notice(5, "wind")] }), 0);
    expect(first.missedNotices).toBe(0); // what was before this page is none of its losses
    const more = reduce(first, { kind: "notice", seq: 3, utc_s: 0, notice: notice(6, "rain") }, 0);
    const again = reduce(more, hello({ notices: [5, 6, 7].map((id) => notice(id, "hail")) }), 0);
    expect([ids(again), again.missedNotices]).toEqual([[4, 5, 6, 7], 0]);
    const late = reduce(again, hello({ notices: [11, 12].map((id) => notice(id, "hail")) }), 0);
    expect([ids(late), late.missedNotices]).toEqual([[4, 5, 6, 7, 11, 12], 3]);
    expect(reduce(late, hello({ mission: mission({ mission_id: "m2" }) }), 0)).toMatchObject({
      notices: [],
      missedNotices: 0,
    });
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
    const later = reduce(state, { kind: "step", seq: 2, utc_s: 0, step: step(2) }, 0);
    expect(later.steps).toEqual([figures(1), figures(2)]);
    expect(later.latestStep).toEqual(step(2));
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
  test("a heartbeat tells how old the mission's last sign of life is, and changes nothing else", () => {
    const known = reduce(INITIAL_STATE, hello(), 1000);
    const heartbeat = { kind: "heartbeat", seq: 1, mission_age_s: 0.4, seen: "m-1/0/0" } as const;
    expect(reduce(known, heartbeat, 9000)).toEqual({ ...known, missionAtMs: 8600 });
  });
  test("what a silent mission has left to tell is no sign of life", () => {
    const atMs = (message: PageMessage): number => reduce(INITIAL_STATE, message, 20_000).missionAtMs;
    expect(atMs(hello({ mission_age_s: 7, seen: "m-1/0/0" }))).toBe(13_000);
    expect(atMs({ ...snapshot(), mission_age_s: 8, seen: "m-1/0/0" })).toBe(12_000);
  });
  test("a mission that should tell its state and does not is silent", () => {
    expect(isSilent(mission(), 1)).toBe(false);
    expect(isSilent(mission(), 2)).toBe(true);
    expect(isSilent(mission({ phase: "done" }), 60)).toBe(false);
    expect(isSilent(null, 60)).toBe(false);
    const replay = { time_s: 0, duration_s: 9, speed: 1, playing: false };
    expect(isSilent(mission({ replay }), 60)).toBe(false);
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
