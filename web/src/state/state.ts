/** State of the page: a pure reducer over the messages of the station. */
import type { Connection, PageMessage } from "../api/socket";
import type { Capabilities, Mission, Notice, Picture, PictureKind, Step, StepFigures } from "../api/types";
import type { KeptState } from "../offline/last_state";
import { noticesToKeep } from "./alerts";
import { STALE_AFTER_S } from "./freshness";
import { extendSamples, type Sample } from "./samples";

/** East and north in metres. */
export type EnuPoint = readonly [number, number];

export interface State {
  readonly connection: Connection;
  readonly mission: Mission | null;
  /** Mission that this page showed before; null if there was none. */
  readonly formerMissionId: string | null;
  /** Time of the last update of the mission, in milliseconds of the page's clock. */
  readonly missionAtMs: number;
  /**
   * Clock time at which the state was valid, in milliseconds since 1970, if it was kept by a page of an earlier visit; null
   * for one that the station has sent to this page.
   */
  readonly keptAtMs: number | null;
  /** Functions that the station offers. */
  readonly capabilities: Capabilities;
  /** Figures of all steps, oldest first. */
  readonly steps: readonly StepFigures[];
  readonly latestStep: Step | null;
  /** Oldest first. */
  readonly notices: readonly Notice[];
  /** Number of notices of this mission that came and went while this page was disconnected. */
  readonly missedNotices: number;
  readonly pictures: Readonly<Partial<Record<PictureKind, Picture>>>;
  readonly trails: ReadonlyMap<number, readonly EnuPoint[]>;
  /** Oldest first, about one per second of the mission. */
  readonly samples: readonly Sample[];
  /** Counts the plans of the mission: a plan that was read before a change is outdated. */
  readonly planRevision: number;
}

export const INITIAL_STATE: State = {
  connection: "connecting",
  mission: null,
  formerMissionId: null,
  missionAtMs: 0,
  keptAtMs: null,
  capabilities: {
    planning: false,
    viewer: false,
    findings: false,
    operation: false,
    survey: false,
    handover: false,
    wall: false,
    video: false,
  },
  steps: [],
  latestStep: null,
  notices: [],
  missedNotices: 0,
  pictures: {},
  trails: new Map(),
  samples: [],
  planRevision: 0,
};

const NOTICES_KEPT = 200;
const TRAIL_POINTS_KEPT = 240;
const TRAIL_SPACING_M = 0.7;

/** Return the state after a message; the given state is not changed. */
export function reduce(state: State, message: PageMessage, nowMs: number): State {
  switch (message.kind) {
    case "hello": {
      // What was kept from an earlier visit says nothing about what this page has missed.
      if (state.keptAtMs !== null) return reduce({ ...INITIAL_STATE, connection: state.connection }, message, nowMs);
      // While connected, a hello of a replay means that it has moved to another time.
      const isJump = state.connection === "open" && message.mission.replay !== null;
      const isSame = state.mission?.mission_id === message.mission.mission_id && !isJump;
      const known = isSame ? state.notices : [];
      const shownId = state.mission?.mission_id ?? message.mission.mission_id;
      return {
        connection: state.connection,
        mission: message.mission,
        formerMissionId: shownId === message.mission.mission_id ? state.formerMissionId : shownId,
        missionAtMs: signOfLifeMs(message, nowMs),
        keptAtMs: null,
        capabilities: message.capabilities,
        steps: message.steps,
        latestStep: message.latest_step,
        notices: addNotices(known, message.notices, message.mission),
        missedNotices: (isSame ? state.missedNotices : 0) + missedBetween(known, message.notices),
        pictures: indexPictures({}, message.pictures),
        trails: extendTrails(isSame ? state.trails : new Map(), message.mission),
        samples: extendSamples(isSame ? state.samples : [], message.mission, hasPaused(state, nowMs)),
        // The plan may have changed while the page was disconnected.
        planRevision: state.planRevision + 1,
      };
    }
    case "snapshot":
      return {
        ...state,
        mission: message.mission,
        missionAtMs: signOfLifeMs(message, nowMs),
        trails: extendTrails(state.trails, message.mission),
        samples: extendSamples(state.samples, message.mission, hasPaused(state, nowMs)),
      };
    case "step":
      return addStep(state, message.step);
    case "notice":
      return { ...state, notices: addNotices(state.notices, [message.notice], state.mission) };
    case "pictures":
      return { ...state, pictures: indexPictures(state.pictures, message.pictures) };
    case "plan":
      return { ...state, planRevision: state.planRevision + 1 };
    case "heartbeat":
      // Nothing has changed: the known state was valid at the last update of the mission.
      return { ...state, missionAtMs: signOfLifeMs(message, nowMs) };
  }
}

/** State of an earlier visit, as old as it is by the clock; a clock that was set back since does not tell. */
export function restore(state: State, kept: KeptState, nowMs: number, clockMs: number): State {
  const { mission, capabilities, steps, latestStep, notices, validAtMs } = kept;
  const age_ms = clockMs < validAtMs ? Infinity : clockMs - validAtMs;
  return {
    ...INITIAL_STATE,
    ...{ connection: state.connection, mission, capabilities, steps, latestStep, notices },
    missionAtMs: nowMs - age_ms,
    keptAtMs: validAtMs,
  };
}

const signOfLifeMs = ({ mission_age_s }: { readonly mission_age_s: number }, nowMs: number): number =>
  nowMs - 1000 * mission_age_s;

/** Whether there was no data for so long that the values in between are unknown; recordings are complete. */
const hasPaused = ({ mission, missionAtMs }: State, nowMs: number): boolean =>
  mission !== null && mission.replay === null && nowMs - missionAtMs > 1000 * STALE_AFTER_S;

const lastId = (notices: readonly Notice[]): number => notices.at(-1)?.notice_id ?? 0;

/** Known notices with the added ones; repeated notices are left out. */
function addNotices(known: readonly Notice[], added: readonly Notice[], mission: Mission | null): readonly Notice[] {
  const last = lastId(known);
  const all = [...known, ...added.filter(({ notice_id }) => notice_id > last)];
  return noticesToKeep(all, mission?.acknowledgements ?? [], NOTICES_KEPT);
}

/** Number of notices since the last known one that the message does not bring. */
function missedBetween(known: readonly Notice[], received: readonly Notice[]): number {
  if (known.length === 0) return 0;
  const last = lastId(known);
  const added = received.filter(({ notice_id }) => notice_id > last).length;
  return Math.max(0, lastId(received) - last - added);
}

/** State with the added step; a hello may contain a step that is also on its way as an event. */
function addStep(state: State, step: Step): State {
  const last = state.steps.at(-1);
  if (last !== undefined && step.step <= last.step) return state;
  // Of earlier steps only the figures are kept: a mission of hours with many vehicles has millions of waypoints.
  const { fitness: _fitness, missing: _missing, target: _target, waypoints: _waypoints, ...figures } = step;
  return { ...state, steps: [...state.steps, figures], latestStep: step };
}

function indexPictures(known: State["pictures"], added: readonly Picture[]): State["pictures"] {
  return { ...known, ...Object.fromEntries(added.map((picture) => [picture.kind, picture])) };
}

/** Trails with the current positions; the same map when no vehicle has moved. */
function extendTrails(trails: State["trails"], mission: Mission): State["trails"] {
  let extended: Map<number, readonly EnuPoint[]> | null = null;
  for (const { vehicle_id: id, position } of mission.vehicles) {
    if (position === null) continue;
    const trail = trails.get(id) ?? [];
    const last = trail.at(-1);
    const moved =
      last === undefined || Math.hypot(position.east_m - last[0], position.north_m - last[1]) > TRAIL_SPACING_M;
    if (!moved) continue;
    const point: EnuPoint = [position.east_m, position.north_m];
    extended ??= new Map(trails);
    extended.set(id, [...trail, point].slice(-TRAIL_POINTS_KEPT));
  }
  return extended ?? trails;
}
