/** Requests about who of several operators has control. */
import { type Answer, request } from "./client";
import type { Control } from "./types";

const isControl = (value: unknown): value is Control =>
  typeof value === "object" && value !== null && Array.isArray((value as { operators?: unknown }).operators);

export const askForControl = (): Promise<Answer<Control>> => request("POST", "/api/control/request", isControl);

/** Give control to an operator who asks for it, or refuse. */
export const answerRequest = (operator: string, granted: boolean): Promise<Answer<Control>> =>
  request("POST", "/api/control/answer", isControl, { operator, granted });

/** Take over control; without a reason only from an operator who is gone. */
export const takeControl = (reason: string): Promise<Answer<Control>> =>
  request("POST", "/api/control/take", isControl, { reason });

export const releaseControl = (): Promise<Answer<Control>> => request("POST", "/api/control/release", isControl);
