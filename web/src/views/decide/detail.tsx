/** Details of one finding: position in every notation, its error, and the operators' decision and comments. */
import { useEffect, useState } from "preact/hooks";
import { changeFinding } from "../../api/findings";
import type { Finding, FindingChange } from "../../api/types";
import { type Notation, NOTATIONS, written } from "../../coordinates";
import { eastNorth, likelihood } from "../../format";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { type Fact, Facts } from "../../ui/facts";
import { Panel } from "../../ui/panel";
import { ellipseText, sightingsText, significanceText, STATUS_SIGNS, statusText, timeText } from "./findings";
import { FindingPictures } from "./pictures";

/** Position in the notations that search teams use, the chosen one first; none without an origin on the globe. */
export function notations({ position }: Finding, chosen: Notation): [Notation, string][] {
  const { latitude_deg, longitude_deg } = position;
  if (latitude_deg === null || longitude_deg === null) return [];
  const ordered = [chosen, ...NOTATIONS.filter((notation) => notation !== chosen)];
  const all = ordered.map((name): [Notation, string] => [name, written({ latitude_deg, longitude_deg }, name)]);
  // Beyond the reach of UTM several notations are the same.
  return all.filter(([, text], index) => all.findIndex(([, other]) => other === text) === index);
}

export function FindingDetail({ finding }: { finding: Finding }) {
  const { mayJudge: mayDecide, notation } = useShell();
  const title = texts.decide.finding(finding.finding_id);
  const facts: Fact[] = [
    [texts.decide.local, eastNorth(finding.position.east_m, finding.position.north_m)],
    [texts.decide.ellipse, ellipseText(finding)],
    [texts.decide.views, sightingsText(finding)],
    [texts.decide.kind, texts.names.findingKind[finding.kind]],
    [texts.decide.confidence, likelihood(finding.person_confidence)],
    [texts.decide.significance, significanceText(finding)],
    [texts.decide.reasons, finding.reasons.length > 0 ? finding.reasons.join("; ") : texts.noData],
    [texts.decide.found, timeText(finding, finding.found_at_s)],
    [texts.decide.seen, timeText(finding, finding.seen_at_s)],
  ];
  return (
    <Panel
      title={title}
      testId="finding-detail"
      class="finding-detail scroll"
      aside={
        <span class={`badge finding-status is-${finding.status}`} data-testid="finding-status" role="status">
          {statusText(finding)}
          {finding.operator !== "" && ` · ${finding.operator}`}
        </span>
      }
    >
      <div class="finding-pictures">
        <FindingPictures key={finding.finding_id} finding={finding} />
        {mayDecide && finding.merged_into === null && <Decision finding={finding} />}
      </div>
      <ul class="notations">
        {notations(finding, notation).map(([name, text]) => (
          <li key={name}>
            <span class="small">{texts.places.notation[name]}</span>
            <b data-testid={`position-${name}`}>{text}</b>
            <Copy text={text} label={texts.decide.copyNotation(texts.places.notation[name])} />
          </li>
        ))}
      </ul>
      <Facts facts={facts} class="finding-facts" />
      {mayDecide ? <RemarksForm key={finding.finding_id} finding={finding} /> : <Remarks finding={finding} />}
    </Panel>
  );
}

function Remarks({ finding: { comment, assignee } }: { finding: Finding }) {
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

function Decision({ finding }: { finding: Finding }) {
  const { isConnected } = useShell();
  const [refusal, change] = useChange(finding);
  return (
    <div class="decision" role="group" aria-label={texts.decide.decision}>
      {(["confirmed", "rejected", "new"] as const).map((status) => (
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

function RemarksForm({ finding }: { finding: Finding }) {
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

function Copy({ text, label }: { text: string; label: string }) {
  const [copied, setCopied] = useState<string | null>(null);
  const copy = async (): Promise<void> => {
    try {
      await navigator.clipboard.writeText(text);
      setCopied(text);
    } catch {
      setCopied(null); // refused by the browser; the text can still be selected
    }
  };
  // Browsers disable the clipboard on pages with a plain HTTP address of another machine.
  if (!window.isSecureContext) return null;
  return (
    <button type="button" aria-label={label} onClick={() => void copy()}>
      {copied === text ? texts.decide.copied : texts.decide.copy}
    </button>
  );
}
