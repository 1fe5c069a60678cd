/** The operators' decision on a finding, their comment, and who it is assigned to. */
import { useEffect, useRef, useState } from "preact/hooks";
import { changeFinding } from "../../api/findings";
import type { Finding, FindingChange } from "../../api/types";
import { useShell } from "../../shell/context";
import { DraftKeeper } from "../../state/draft_keeper";
import { texts } from "../../texts";
import { STATUS_SIGNS } from "./findings";
import { afterRemarks, changedRemarks, type RemarkName, type RemarksDraft, type RemarksReading } from "./remarks";

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

interface DecisionProps {
  finding: Finding;
  /** Whether it is what the view was opened for: then it gets the focus, unless the operator works there already. */
  takesFocus?: boolean;
}

export function Decision({ finding, takesFocus = false }: DecisionProps) {
  const { isConnected } = useShell();
  const [refusal, change] = useChange(finding);
  const group = useRef<HTMLDivElement>(null);
  // Who comes from an alert or by a key decides next.
  useEffect(() => {
    if (takesFocus && !document.activeElement?.closest("main *")) group.current?.focus({ preventScroll: true });
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

const drafts = new DraftKeeper<RemarksDraft, RemarksReading>(({ key }) => key, afterRemarks);

/** Hook for the remarks being typed, which late answers of the station leave as they are. */
function useRemarks(key: string, { comment, assignee }: Finding): RemarksDraft {
  const [draft, setDraft] = useState(() => drafts.of(key));
  useEffect(() => drafts.subscribe(setDraft), []);
  useEffect(() => drafts.read({ key, stored: { comment, assignee } }), [key, comment, assignee]);
  return draft?.key === key ? draft : afterRemarks(null, { key, stored: { comment, assignee } });
}

export function RemarksForm({ finding }: { finding: Finding }) {
  const { isConnected, state } = useShell();
  const key = `${state.mission?.mission_id ?? ""} ${finding.finding_id}`;
  const draft = useRemarks(key, finding);
  const [refusal, change] = useChange(finding);
  const { typed, stored, overtaken } = draft;
  const changed = changedRemarks(draft);
  const type = (name: RemarkName, text: string): void =>
    drafts.change(key, (before) => ({ ...before, typed: { ...before.typed, [name]: text } }));
  return (
    <form
      class="form"
      onSubmit={(event) => {
        event.preventDefault();
        drafts.change(key, (before) => ({ ...before, sent: before.typed }));
        change(changed);
      }}
    >
      <label>
        {texts.decide.comment}
        <textarea
          rows={2}
          maxLength={2000}
          data-testid="finding-comment"
          value={typed.comment}
          onInput={(event) => type("comment", event.currentTarget.value)}
        />
      </label>
      <label>
        {texts.decide.assignee}
        <input
          type="text"
          maxLength={100}
          data-testid="finding-assignee"
          value={typed.assignee}
          onInput={(event) => type("assignee", event.currentTarget.value)}
        />
      </label>
      <div role="status" data-testid="finding-overtaken">
        {overtaken.map((name) => (
          <p key={name} class="small">
            {texts.decide.overtaken(texts.decide[name], stored[name])}
          </p>
        ))}
      </div>
      <div class="button-row">
        <button type="submit" data-testid="finding-save" disabled={!isConnected || Object.keys(changed).length === 0}>
          {texts.decide.save}
        </button>
      </div>
      <p class="is-bad" role="alert" data-testid="finding-refusal">
        {refusal}
      </p>
    </form>
  );
}
