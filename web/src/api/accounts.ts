/** Requests about accounts, which administrators make. */
import { type Answer, request } from "./client";
import type { Account, Invitation, SignInEntry } from "./types";
import type { GivenRole } from "../state/roles";

const isList = <T>(value: unknown): value is T[] => Array.isArray(value);
const isInvitation = (value: unknown): value is Invitation =>
  typeof value === "object" && value !== null && typeof (value as { token?: unknown }).token === "string";

export const readAccounts = (): Promise<Answer<Account[]>> => request("GET", "/api/accounts", isList<Account>);

export const readSignIns = (): Promise<Answer<SignInEntry[]>> =>
  request("GET", "/api/accounts/sign-ins", isList<SignInEntry>);

export const invite = (role: GivenRole): Promise<Answer<Invitation>> =>
  request("POST", "/api/accounts/invitations", isInvitation, { role });

/** Give an account another role, and return all accounts. */
export const changeRole = (name: string, role: GivenRole): Promise<Answer<Account[]>> =>
  request("PATCH", `/api/accounts/${encodeURIComponent(name)}`, isList<Account>, { role });

/** Remove an account, and return the others. */
export const removeAccount = (name: string): Promise<Answer<Account[]>> =>
  request("DELETE", `/api/accounts/${encodeURIComponent(name)}`, isList<Account>);
