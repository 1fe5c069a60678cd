/** What the page knows of the mission: a pure reducer over the service's messages. */
import type { Connection, PageMessage } from "../api/socket";
import type { Mission, Notice, Picture, PictureKind, Step } from "../api/types";
import { extendSamples, type Sample } from "./samples";

/** East and north, metres. */
export type EnuPoint = readonly [number, number];

/** A notice with a number of this page's own: mission time stands still before the start and cannot tell them apart. */
export type NumberedNotice = Notice & { readonly id: number };

export interface State {
  readonly connection: Connection;
  readonly mission: Mission | null;
  /** When the service last told the mission's state, in the page's own milliseconds. */
  readonly missionAtMs: number;
  readonly steps: readonly Step[];
  /** Oldest first. */
  readonly notices: readonly NumberedNotice[];
  readonly pictures: Readonly<Partial<Record<PictureKind, Picture>>>;
  readonly trails: ReadonlyMap<number, readonly EnuPoint[]>;
  /** Oldest first, about one per second of the mission. */
  readonly samples: readonly Sample[];
  /** Counts the plans that the mission has flown by: what was read of one before is old when it changes. */
  readonly planRevision: number;
}

export const INITIAL_STATE: State = {
  connection: "connecting",
  mission: null,
  missionAtMs: 0,
  steps: [],
  notices: [],
  pictures: {},
  trails: new Map(),
  samples: [],
  planRevision: 0,
};

const NOTICES_KEPT = 200;
const TRAIL_POINTS_KEPT = 240;
const TRAIL_SPACING_M = 0.7;

/** Apply one message; the state given is not changed. */
export function reduce(state: State, message: PageMessage, nowMs: number): State {
  switch (message.kind) {
    case "hello": {
      // While connected, a hello tells that a replay has jumped to another time.
      const isSame = state.mission?.mission_id === message.mission.mission_id && state.connection !== "open";
      return {
        connection: state.connection,
        mission: message.mission,
        missionAtMs: nowMs,
        steps: message.steps,
        notices: numberNotices(state.notices, message.notices),
        pictures: indexPictures({}, message.pictures),
        trails: extendTrails(isSame ? state.trails : new Map(), message.mission),
        samples: extendSamples(isSame ? state.samples : [], message.mission),
        // It may have changed while there was no connection.
        planRevision: state.planRevision + 1,
      };
    }
    case "snapshot":
      return {
        ...state,
        mission: message.mission,
        missionAtMs: nowMs,
        trails: extendTrails(state.trails, message.mission),
        samples: extendSamples(state.samples, message.mission),
      };
    case "step":
      return { ...state, steps: addStep(state.steps, message.step) };
    case "notice":
      return { ...state, notices: addNotice(state.notices, message.notice) };
    case "pictures":
      return { ...state, pictures: indexPictures(state.pictures, message.pictures) };
    case "plan":
      return { ...state, planRevision: state.planRevision + 1 };
    case "heartbeat":
      // Nothing has changed: what was told before is true now.
      return { ...state, missionAtMs: nowMs };
  }
}

const lastId = (notices: readonly NumberedNotice[]): number => notices.at(-1)?.id ?? 0;

function addNotice(notices: readonly NumberedNotice[], notice: Notice): readonly NumberedNotice[] {
  return [...notices, { ...notice, id: lastId(notices) + 1 }].slice(-NOTICES_KEPT);
}

/** Those that are known already keep their numbers, so that nobody is alarmed twice. */
function numberNotices(known: readonly NumberedNotice[], notices: readonly Notice[]): readonly NumberedNotice[] {
  const keyOf = ({ elapsed_s, severity, vehicle_id, text }: Notice): string =>
    JSON.stringify([elapsed_s, severity, vehicle_id, text]);
  const ids = new Map<string, number[]>();
  for (const notice of known) ids.set(keyOf(notice), [...(ids.get(keyOf(notice)) ?? []), notice.id]);
  let next = lastId(known) + 1;
  return notices.map((notice) => ({ ...notice, id: ids.get(keyOf(notice))?.shift() ?? next++ }));
}

/** A step that the hello has brought already comes once more when it was on its way. */
function addStep(steps: readonly Step[], step: Step): readonly Step[] {
  const last = steps.at(-1);
  return last !== undefined && step.step <= last.step ? steps : [...steps, step];
}

function indexPictures(known: State["pictures"], added: readonly Picture[]): State["pictures"] {
  return { ...known, ...Object.fromEntries(added.map((picture) => [picture.kind, picture])) };
}

/** The same map when nobody has moved. */
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
