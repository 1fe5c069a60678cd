/** Roles of people at a command post. */
import type { Role } from "../api/types";

/** The least first: each may do all that the ones before it may. */
const ROLES: readonly Role[] = ["visitor", "observer", "analyst", "operator", "administrator"];

/** Roles that an account can have. */
export const GIVEN_ROLES = ["observer", "analyst", "operator", "administrator"] as const;
export type GivenRole = (typeof GIVEN_ROLES)[number];

export const may = (role: Role, needed: Role): boolean => ROLES.indexOf(role) >= ROLES.indexOf(needed);
