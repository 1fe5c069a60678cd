/** The operators' decision on a finding, their comment, and who it is assigned to. */
import { useEffect, useRef, useState } from "preact/hooks";
import { changeFinding } from "../../api/findings";
import type { Finding, FindingChange } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { STATUS_SIGNS } from "./findings";

/** To take a decision back comes last: the other buttons do not move when it appears. */
const DECISIONS = ["confirmed", "rejected", "new"] as const;

export function Remarks({ finding: { comment, assignee } }: { finding: Finding }) {
  return (
    <>
      {assignee !== "" && (
        <p>
          {texts.decide.assignee}: {assignee}
        </p>
      )}
      {comment !== "" && <p>{comment}</p>}
    </>
  );
}

/** Hook that sends a change of a finding and keeps its refusal. */
function useChange({
  finding_id: id,
}: Finding): [refusal: string | null, change: (changed: Partial<FindingChange>) => void] {
  const [refusal, setRefusal] = useState<string | null>(null);
  const change = async (changed: Partial<FindingChange>): Promise<void> => {
    const answer = await changeFinding(id, changed);
    setRefusal(answer.ok ? null : answer.message);
  };
  return [refusal, (changed) => void change(changed)];
}

export function Decision({ finding }: { finding: Finding }) {
  const { isConnected } = useShell();
  const [refusal, change] = useChange(finding);
  const group = useRef<HTMLDivElement>(null);
  // Who comes from an alert or by a key decides next; who works in this view keeps the focus.
  useEffect(() => {
    if (!document.activeElement?.closest("main *")) group.current?.focus({ preventScroll: true });
  }, []);
  return (
    <div ref={group} class="decision" role="group" tabIndex={-1} aria-label={texts.decide.decision}>
      {DECISIONS.filter((status) => status !== "new" || finding.status !== "new").map((status) => (
        <button
          key={status}
          type="button"
          class={status === "confirmed" ? "primary" : ""}
          data-testid={`judge-${status}`}
          disabled={!isConnected || status === finding.status}
          onClick={() => change({ status })}
        >
          {STATUS_SIGNS[status]} {texts.decide.decide[status]}
        </button>
      ))}
      <p class="is-bad" role="alert" data-testid="judge-refusal">
        {refusal}
      </p>
    </div>
  );
}

export function RemarksForm({ finding }: { finding: Finding }) {
  const { isConnected } = useShell();
  const [comment, setComment] = useState(finding.comment);
  const [assignee, setAssignee] = useState(finding.assignee);
  const [refusal, change] = useChange(finding);
  // Shows what another operator has written meanwhile.
  useEffect(() => setComment(finding.comment), [finding.comment]);
  useEffect(() => setAssignee(finding.assignee), [finding.assignee]);
  const isSaved = comment === finding.comment && assignee === finding.assignee;
  return (
    <form
      class="form"
      onSubmit={(event) => {
        event.preventDefault();
        change({ comment, assignee });
      }}
    >
      <label>
        {texts.decide.comment}
        <textarea
          rows={2}
          maxLength={2000}
          data-testid="finding-comment"
          value={comment}
          onInput={(event) => setComment(event.currentTarget.value)}
        />
      </label>
      <label>
        {texts.decide.assignee}
        <input
          type="text"
          maxLength={100}
          data-testid="finding-assignee"
          value={assignee}
          onInput={(event) => setAssignee(event.currentTarget.value)}
        />
      </label>
      <div class="button-row">
        <button type="submit" data-testid="finding-save" disabled={!isConnected || isSaved}>
          {texts.decide.save}
        </button>
      </div>
      <p class="is-bad" role="alert" data-testid="finding-refusal">
        {refusal}
      </p>
    </form>
  );
}
