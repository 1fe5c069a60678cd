/** Display names of what the station sends as identifiers: phases, tasks, modes, kinds of images. */
import type {
  Action,
  FindingKind,
  FindingStatus,
  FlightMode,
  FrameKind,
  Outcome,
  Phase,
  PictureKind,
  Severity,
  Suspension,
  Task,
  WaypointVerdict,
} from "../api/types";

const PHASE: Readonly<Record<Phase, string>> = {
  connect: "Connecting",
  preflight: "Preflight",
  ready: "Ready",
  arm: "Arming",
  takeoff: "Taking off",
  line: "Forming line",
  scan: "Scanning",
  converge: "Converging",
  found: "Found",
  return: "Returning",
  land: "Landing",
  done: "Finished",
};

const SUSPENSION: Readonly<Record<Suspension, string>> = { none: "", paused: "Paused", held: "Holding" };

const OUTCOME: Readonly<Record<Outcome, string>> = {
  open: "In progress",
  found: "Possible person",
  not_found: "Nothing found",
  aborted: "Aborted",
  failed: "Failed",
};

const TASK: Readonly<Record<Task, string>> = {
  idle: "Standby",
  joining: "Joining",
  swarm: "In swarm",
  held: "Holding",
  returning: "Returning",
  landing: "Landing",
  landed: "Landed",
  lost: "Link lost",
};

const MODE: Readonly<Record<Exclude<FlightMode, "unknown">, string>> = {
  manual: "Manual",
  guided: "Guided",
  hold: "Hold",
  takeoff: "Takeoff",
  mission: "Mission",
  return: "Return",
  land: "Land",
};

const ACTION: Readonly<Record<Action, string>> = {
  choose: "Confirm vehicles",
  start: "Launch",
  pause: "Pause",
  resume: "Resume",
  hold: "Hold",
  return: "Return",
  land: "Land",
  abort: "Abort",
  focus: "Focus",
  override: "Override",
  join: "Join",
  ready: "Confirm ready",
  not_ready: "Mark as not ready",
  new_sortie: "New sortie",
};

const SEVERITY: Readonly<Record<Severity, string>> = {
  info: "Info",
  warning: "Warning",
  news: "Found",
  critical: "Critical",
};

const PICTURE: Readonly<Record<PictureKind, string>> = {
  integral: "Integral",
  thermal: "Thermal",
  anomaly: "Anomaly",
  coverage: "Coverage",
  visibility: "Visibility",
  views: "Independent views",
  detection: "Probability of detection",
  floor: "Forest floor",
  prior: "Probability before the search",
};

const FRAME: Readonly<Record<FrameKind, string>> = { colour: "Colour", thermal: "Thermal" };

const VERDICT: Readonly<Record<WaypointVerdict, string>> = { sent: "Sent", shortened: "Shortened", held: "Held" };

const FINDING_KIND: Readonly<Record<FindingKind, string>> = {
  undecided: "Undecided",
  person: "Possible person",
  animal: "Animal?",
  warm_object: "Warm object?",
  object: "Object, not warm",
  anomaly: "Anomaly",
};

const FINDING: Readonly<Record<FindingStatus, string>> = {
  new: "undecided",
  confirmed: "confirmed",
  rejected: "rejected",
};

/** MAVLink's GPS_FIX_TYPE. */
const GPS_FIX: Readonly<Record<number, string>> = {
  0: "no GPS",
  1: "no fix",
  2: "2D",
  3: "3D",
  4: "DGPS",
  5: "RTK float",
  6: "RTK",
  7: "static",
  8: "PPP",
};

/** What a strategy did in a step; strategies may add others, which are shown as they are. */
const BRANCH: Readonly<Record<string, string>> = {
  line: "Line scan",
  grid: "Grid scan",
  pso: "Swarm search",
  archive: "Archive search",
  hold: "Hold",
};

const EVOLUTIONARY_STATE: Readonly<Record<string, string>> = {
  exploration: "Exploration",
  exploitation: "Exploitation",
  convergence: "Convergence",
  jumping_out: "Jumping out",
};

export const names = {
  phase: PHASE,
  suspension: SUSPENSION,
  outcome: OUTCOME,
  task: TASK,
  mode: MODE,
  action: ACTION,
  severity: SEVERITY,
  picture: PICTURE,
  frame: FRAME,
  verdict: VERDICT,
  finding: FINDING,
  findingKind: FINDING_KIND,
  gpsFix: GPS_FIX,
  branch: BRANCH,
  evolutionaryState: EVOLUTIONARY_STATE,
} as const;
