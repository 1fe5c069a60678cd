/** Proposals of others for the plan. */
import type { Proposal } from "../api/types";

/** Those that nobody has decided about. */
export const waiting = (proposals: readonly Proposal[]): Proposal[] => proposals.filter(({ use }) => use === null);

/** Number of waiting proposals of one sender from which they can be dismissed together. */
const MANY = 4;

/** Waiting proposals of each sender who has sent many, by the sender's name. */
export function bySender(open: readonly Proposal[]): [sender: string, proposals: Proposal[]][] {
  const senders = new Map<string, Proposal[]>();
  for (const proposal of open) senders.set(proposal.sender, [...(senders.get(proposal.sender) ?? []), proposal]);
  return [...senders].filter(([, proposals]) => proposals.length >= MANY);
}
