/** List of findings, undecided ones first. */
import type { Finding } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { evidenceText, type Filter, sightingsText, statusText, timeText } from "./findings";
import { Thumbnail } from "./thumbnail";

interface Props {
  findings: readonly Finding[];
  filter: Filter;
  chosen: number | null;
  onChoose(id: number): void;
}

export function FindingList({ findings, filter, chosen, onChoose }: Props) {
  const { mission } = useShell().state;
  if (findings.length === 0) return <p class="empty">{texts.decide.none[filter]}</p>;
  return (
    <ul class="finding-list scroll">
      {findings.map((finding) => (
        <li key={finding.finding_id}>
          <button
            type="button"
            data-testid={`finding-${finding.finding_id}`}
            data-status={finding.status}
            aria-pressed={finding.finding_id === chosen}
            onClick={() => onChoose(finding.finding_id)}
          >
            <Thumbnail finding={finding} shot={{ kind: "integral" }} />
            <span>
              <b>{texts.decide.finding(finding.finding_id)}</b>
              <br />
              <span class={`finding-status is-${finding.status}`}>
                {statusText(finding)} · {texts.names.findingKind[finding.kind]}
              </span>
              <br />
              <span class="small">
                {evidenceText(finding)} · {sightingsText(finding)} · {timeText(finding, finding.seen_at_s, mission)}
              </span>
              {finding.assignee !== "" && (
                <>
                  <br />
                  <span class="small">→ {finding.assignee}</span>
                </>
              )}
            </span>
          </button>
        </li>
      ))}
    </ul>
  );
}
