/** Requests about proposals of others for the plan; the list itself is part of the state of the mission. */
import { type Answer, request } from "./client";
import type { Proposal, ProposalUse } from "./types";

const isProposal = (value: unknown): value is Proposal =>
  typeof value === "object" && value !== null && "proposal_id" in value && typeof value.proposal_id === "number";

/** Put on record what the operator makes of a proposal. */
export const decideProposal = (id: number, use: ProposalUse): Promise<Answer<Proposal>> =>
  request("POST", `/api/proposals/${id}`, isProposal, { use });
