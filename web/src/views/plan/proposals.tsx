/** Proposals of others for the plan: the decision goes on record first, and the draft of the plan changes with it. */
import { useState } from "preact/hooks";
import { decideProposal } from "../../api/proposals";
import type { Plan, Proposal, ProposalUse } from "../../api/types";
import { timeOfDay } from "../../format";
import { bySender, waiting } from "../../state/proposals";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { withProposal } from "./shapes";

interface Props {
  proposals: readonly Proposal[];
  /** Whether this page may decide; observers see what waits. */
  mayDecide: boolean;
  /** Called once the station has answered: with a change, since the plan may be edited meanwhile. */
  onPlan(take: (plan: Plan) => Plan): void;
}

export function ProposalsPanel({ proposals, mayDecide, onPlan }: Props) {
  const [busyId, setBusyId] = useState<number | null>(null);
  const [refusal, setRefusal] = useState<string | null>(null);
  const open = waiting(proposals);
  const decide = async (proposal: Proposal, use: ProposalUse): Promise<void> => {
    setBusyId(proposal.proposal_id);
    const answer = await decideProposal(proposal.proposal_id, use);
    setBusyId(null);
    setRefusal(answer.ok ? null : answer.message);
    if (answer.ok) onPlan((plan) => withProposal(plan, answer.value));
  };
  const dismiss = async (unwanted: readonly Proposal[]): Promise<void> => {
    for (const proposal of unwanted) await decide(proposal, "dismissed");
  };
  if (open.length === 0 && refusal === null) return null;
  return (
    <Panel title={texts.plan.proposals.panel} testId="plan-proposals">
      <ul class="proposals">
        {open.map((proposal) => (
          <li key={proposal.proposal_id} data-testid={`proposal-${proposal.proposal_id}`}>
            <p>
              <strong>{proposal.name}</strong> <span class="small">{describe(proposal)}</span>
            </p>
            {proposal.remarks !== "" && <p class="small">{proposal.remarks}</p>}
            {mayDecide && (
              <div class="proposal-uses">
                {proposal.uses.map((use) => (
                  <button
                    key={use}
                    type="button"
                    disabled={busyId !== null}
                    data-testid={`proposal-${proposal.proposal_id}-${use}`}
                    onClick={() => void decide(proposal, use)}
                  >
                    {texts.plan.proposals.use[use]}
                  </button>
                ))}
              </div>
            )}
          </li>
        ))}
      </ul>
      {mayDecide &&
        bySender(open).map(([sender, unwanted]) => (
          <button
            key={sender}
            type="button"
            disabled={busyId !== null}
            data-testid="proposals-dismiss"
            onClick={() => void dismiss(unwanted)}
          >
            {texts.plan.proposals.dismissAll(unwanted.length, sender || texts.plan.proposals.somebody)}
          </button>
        ))}
      <p class="is-bad field-problem" role="alert">
        {refusal}
      </p>
    </Panel>
  );
}

/** Who has sent it when, what it is, and whether it is out of date. */
export function describe(proposal: Proposal, nowUtc_s: number = Date.now() / 1000): string {
  const { source, sender, shape, places, altitude_amsl_m: altitude_m, sent_utc_s, stale_utc_s } = proposal;
  const words = texts.plan.proposals;
  const parts = [
    words.sent(sender || words.somebody, source, timeOfDay(sent_utc_s)),
    shape === "point" ? words.shape.point : `${words.shape[shape]}, ${texts.plan.corners(places.length)}`,
  ];
  if (altitude_m !== null) parts.push(words.altitude(Math.round(altitude_m)));
  if (stale_utc_s < nowUtc_s) parts.push(words.stale(timeOfDay(stale_utc_s)));
  return parts.join("; ");
}
