/** Requests to the service. */
import { texts } from "../texts";
import type { Action, ActionResponse, ErrorBody } from "./types";

export type ActionAnswer = { ok: true; response: ActionResponse } | { ok: false; message: string };

const isErrorBody = (value: unknown): value is ErrorBody =>
  typeof value === "object" && value !== null && typeof (value as { message?: unknown }).message === "string";
const isActionResponse = (value: unknown): value is ActionResponse =>
  typeof value === "object" && value !== null && Array.isArray((value as { results?: unknown }).results);

/** Send an operator's action. Refusals and a lost connection are values, since the operator has to read them. */
export async function postAction(action: Action, vehicleIds: readonly number[] | null): Promise<ActionAnswer> {
  try {
    const response = await fetch("/api/mission/actions", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ action, vehicle_ids: vehicleIds }),
    });
    const body: unknown = await response.json();
    if (response.ok && isActionResponse(body)) return { ok: true, response: body };
    return { ok: false, message: isErrorBody(body) ? body.message : texts.actions.unreadableAnswer };
  } catch {
    return { ok: false, message: texts.actions.notSent };
  }
}
