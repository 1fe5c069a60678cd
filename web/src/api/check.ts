/** Runtime check of messages: text in, typed message out, or an error that names the problem. */
import type { MissedEvents, Mission, ServerMessage } from "./types";

const SCHEMA_VERSION = 5;

/** A message that this page cannot understand. */
export class ProtocolError extends Error {}

type Kind = ServerMessage["kind"];
type Json = Record<string, unknown>;
type Check = (value: unknown) => boolean;

const isObject = (value: unknown): value is Json =>
  typeof value === "object" && value !== null && !Array.isArray(value);
const isNumber: Check = (value) => typeof value === "number";
const isString: Check = (value) => typeof value === "string";
const isBoolean: Check = (value) => typeof value === "boolean";
const listOf =
  (check: Check): Check =>
  (value) =>
    Array.isArray(value) && value.every(check);
const orNull =
  (check: Check): Check =>
  (value) =>
    value === null || check(value);
const shape =
  (fields: Record<string, Check>): Check =>
  (value) =>
    isObject(value) && Object.entries(fields).every(([name, check]) => check(value[name]));

const vertex = shape({ east_m: isNumber, north_m: isNumber });
const position = shape({ east_m: isNumber, north_m: isNumber, up_m: isNumber });
const vehicle = shape({
  vehicle_id: isNumber,
  mode: isString,
  task: isString,
  position: orNull(position),
  waypoint: orNull(position),
  home: orNull(position),
  link_age_s: orNull(isNumber),
  components: listOf(shape({ component_id: isNumber, name: isString })),
  camera: orNull(shape({ footprint: listOf(vertex) })),
});
const target = shape({ position, sightings: isNumber });
const finding = shape({ finding_id: isNumber, status: isString, position, ellipse: orNull(isObject) });
const mission = shape({
  mission_id: isString,
  phase: isString,
  suspension: isString,
  outcome: isString,
  elapsed_s: isNumber,
  step: isNumber,
  area: listOf(vertex),
  fence: listOf(vertex),
  no_go: listOf(listOf(vertex)),
  vehicles: listOf(vehicle),
  preflight: listOf(shape({ vehicle_id: isNumber, name: isString, status: isString })),
  target: orNull(target),
  targets: listOf(target),
  left_for_later: listOf(shape({ position: vertex, person_confidence: isNumber })),
  findings: listOf(finding),
  acknowledgements: listOf(shape({ notice_id: isNumber, operator: isString, utc_s: isNumber })),
  allowed_actions: listOf(isString),
});
const FIGURES = {
  step: isNumber,
  elapsed_s: isNumber,
  visibility_m2: orNull(isNumber),
  threshold_m2: orNull(isNumber),
};
const step = shape({
  ...FIGURES,
  waypoints: listOf(shape({ vehicle_id: isNumber, requested: position, verdict: isString })),
});
const notice = shape({ severity: isString, notice_id: isNumber, text: isString, elapsed_s: isNumber, utc_s: isNumber });
const capabilities = shape({
  planning: isBoolean,
  viewer: isBoolean,
  findings: isBoolean,
  survey: isBoolean,
  handover: isBoolean,
  wall: isBoolean,
  video: isBoolean,
});
/** Fields of messages that describe the state, or say that it is unchanged. */
const AGE = { mission_age_s: isNumber, seen: isString };
const picture = shape({ kind: isString, step: isNumber, url: isString, corners: listOf(vertex) });

const FIELDS: Record<Kind, Record<string, Check>> = {
  hello: {
    ...AGE,
    schema_version: isNumber,
    capabilities,
    mission,
    steps: listOf(shape(FIGURES)),
    latest_step: orNull(step),
    notices: listOf(notice),
    pictures: listOf(picture),
  },
  snapshot: { ...AGE, mission },
  changes: { ...AGE, mission: isObject, vehicles: listOf(shape({ vehicle_id: isNumber })), preflight: Array.isArray },
  step: { step },
  notice: { notice },
  pictures: { pictures: listOf(picture) },
  plan: {},
  answer: { request_id: isString, status: isNumber, response: orNull(isObject), error: orNull(isObject) },
  heartbeat: AGE,
};

const isKind = (value: unknown): value is Kind => isString(value) && Object.hasOwn(FIELDS, value as string);

/** Return the mission, or throw if the changes have made it invalid. */
export function checkedMission(value: Mission): Mission {
  if (!mission(value)) throw new ProtocolError("changes of the mission do not fit to what was known of it");
  return value;
}

/** Parse and check one message of the event stream. */
export function parseServerMessage(text: string): ServerMessage {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    throw new ProtocolError("a message of the service is not JSON");
  }
  return checkedMessage(value);
}

/** Return the message, or throw with the problem. */
function checkedMessage(value: unknown): ServerMessage {
  if (!isObject(value) || !isKind(value["kind"])) throw new ProtocolError("a message of the service has no known kind");
  const kind = value["kind"];
  if (kind === "hello" && value["schema_version"] !== SCHEMA_VERSION) {
    throw new ProtocolError(
      `the service speaks version ${String(value["schema_version"])}, this page ${SCHEMA_VERSION}`,
    );
  }
  const fields = kind === "answer" ? FIELDS[kind] : { seq: isNumber, ...FIELDS[kind] };
  for (const [name, check] of Object.entries(fields)) {
    if (!check(value[name])) throw new ProtocolError(`the field '${name}' of a '${kind}' message is not as expected`);
  }
  return value as unknown as ServerMessage;
}

/** Whether an answer holds missed events, each valid as on the stream. */
export function isMissedEvents(value: unknown): value is MissedEvents {
  if (!isObject(value) || !isNumber(value["seq"]) || !Array.isArray(value["events"])) return false;
  try {
    value["events"].forEach(checkedMessage);
    return true;
  } catch {
    return false;
  }
}
