/** Proposals of others for the plan. */
import type { Proposal } from "../api/types";

/** Those that nobody has decided about. */
export const waiting = (proposals: readonly Proposal[]): Proposal[] => proposals.filter(({ use }) => use === null);
