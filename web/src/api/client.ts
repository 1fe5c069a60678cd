/** Requests to the station. Refusals and lost connections are values, since the operator has to read them. */
import { said, texts } from "../texts";
import { isMissedEvents } from "./check";
import { noteSeen, SEEN_HEADER, seenHeader } from "./seen";
import type { Action, ActionResponse, Basemap, ErrorBody, MissedEvents, PreflightCheck, Session } from "./types";

export type Answer<T> =
  { readonly ok: true; readonly value: T } | { readonly ok: false; readonly message: string; readonly status?: number };

export type ActionAnswer = Answer<ActionResponse>;

export interface ActionToSend {
  readonly action: Action;
  /** Null for the whole mission. */
  readonly vehicleIds: readonly number[] | null;
  /** Height for the action `focus`; null resets it to automatic. */
  readonly focalHeight_m?: number | null;
  /** Name of this press, for one that is sent by the event stream as well. */
  readonly requestId?: string | null;
}

/** Time after which a request without an answer counts as lost; longer than a busy station needs for any of them. */
const LOST_AFTER_MS = 60_000;
/** The same for the role of this page: its answer takes the station no time, and decides on the command buttons. */
const SESSION_LOST_AFTER_MS = 2000;

export type Guard<T> = (value: unknown) => value is T;

const isErrorBody = (value: unknown): value is ErrorBody =>
  typeof value === "object" && value !== null && typeof (value as { message?: unknown }).message === "string";
const isActionResponse = (value: unknown): value is ActionResponse =>
  typeof value === "object" && value !== null && Array.isArray((value as { results?: unknown }).results);

/** Send a request with a file or JSON, and check the answer with `isExpected`. Without an answer it fails. */
export async function request<T>(
  method: "GET" | "POST" | "PUT" | "PATCH" | "DELETE",
  path: string,
  isExpected: Guard<T>,
  body?: unknown,
  lostAfterMs = LOST_AFTER_MS,
): Promise<Answer<T>> {
  try {
    const signal = AbortSignal.timeout(lostAfterMs);
    const headers = method === "GET" ? {} : { ...contentType(body), ...seenHeader() };
    const response = await fetch(path, { method, signal, headers, body: content(body) });
    noteSeen(response.headers.get(SEEN_HEADER));
    const value = response.status === 204 ? null : parsed(await response.text());
    if (response.ok && isExpected(value)) return { ok: true, value };
    return refusal(value, response);
  } catch {
    return { ok: false, message: texts.requests.notSent };
  }
}

/** What a refused request is told by a station that answers those that it grants with a picture or a document. */
export const refused = async (response: Response): Promise<Answer<never>> =>
  refusal(parsed(await response.text()), response);

function refusal(value: unknown, { status }: Response): Answer<never> {
  const message = isErrorBody(value) ? said(value.message) : texts.requests.unreadableAnswer;
  return { ok: false, message, status };
}

/** Value of JSON; undefined for another text, such as the page of a proxy. */
function parsed(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

function contentType(body: unknown): Record<string, string> {
  if (body === undefined) return {};
  return { "Content-Type": body instanceof Blob ? "application/octet-stream" : "application/json" };
}

function content(body: unknown): Blob | string | null {
  if (body === undefined) return null;
  return body instanceof Blob ? body : JSON.stringify(body);
}

/** Send an operator's action; answers when every vehicle has accepted or refused it. */
export function postAction(toSend: ActionToSend): Promise<ActionAnswer> {
  const { action, vehicleIds, focalHeight_m = null, requestId = null } = toSend;
  const body = { action, vehicle_ids: vehicleIds, focal_height_m: focalHeight_m, request_id: requestId };
  return request("POST", "/api/mission/actions", isActionResponse, body);
}

const isNothing = (value: unknown): value is null => value === null;

/** Acknowledge notices on behalf of all operators. */
export const acknowledgeNotices = (notice_ids: readonly number[]): Promise<Answer<null>> =>
  request("POST", "/api/notices/acknowledge", isNothing, { notice_ids });

const isCheck = (value: unknown): value is PreflightCheck =>
  typeof value === "object" && value !== null && typeof (value as { status?: unknown }).status === "string";

/** Override a failed check, so that it does not block the launch; without a reason, remove the override. */
export function overrideCheck(
  { vehicle_id, name }: Pick<PreflightCheck, "vehicle_id" | "name">,
  reason: string | null,
): Promise<Answer<PreflightCheck>> {
  return request("POST", "/api/preflight/override", isCheck, { vehicle_id, check: name, reason });
}

const isSession = (value: unknown): value is Session =>
  typeof value === "object" && value !== null && typeof (value as { role?: unknown }).role === "string";

/** Read the role of this page: operator or observer. */
export const readSession = (): Promise<Answer<Session>> =>
  request("GET", "/api/session", isSession, undefined, SESSION_LOST_AFTER_MS);

/** Sign in as operator: the station sets a cookie that scripts cannot read. */
export const signIn = (code: string, name: string): Promise<Answer<Session>> =>
  request("POST", "/api/session", isSession, { code, name });

/** Sign in with an account. */
export const signInByAccount = (name: string, password: string): Promise<Answer<Session>> =>
  request("POST", "/api/session", isSession, { name, password });

/** Make an account by an invitation, and sign in with it. */
export const joinByInvitation = (token: string, name: string, password: string): Promise<Answer<Session>> =>
  request("POST", "/api/session/invitation", isSession, { token, name, password });

/** End the session of this page. */
export const signOut = (): Promise<Answer<Session>> => request("DELETE", "/api/session", isSession);

/** Read the events after a number, for a page that was disconnected or too slow. */
export const readMissedEvents = (after: number): Promise<Answer<MissedEvents>> =>
  request("GET", `/api/events?after=${after}`, isMissedEvents);

const isBasemap = (value: unknown): value is Basemap =>
  typeof value === "object" &&
  value !== null &&
  "url" in value &&
  (value.url === null || typeof value.url === "string");

/** Read the address of the station's base map, if it has one. */
export const readBasemap = (): Promise<Answer<Basemap>> => request("GET", "/api/basemap", isBasemap);
