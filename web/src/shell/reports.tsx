/** Results of the recent commands for each vehicle, refusals first. */
import type { ActionResponse } from "../api/types";
import { said, texts } from "../texts";
import type { Report } from "./commands";

interface Props {
  reports: readonly Report[];
  /** Whether to name only the vehicles that refused. */
  isBrief?: boolean;
}

export function Reports({ reports, isBrief = false }: Props) {
  return (
    <div class="reports" data-testid="results" role="status">
      {reports.map((report, index) => (
        <ReportItem key={report.id} report={report} isNewest={index === 0} isBrief={isBrief} />
      ))}
    </div>
  );
}

interface ItemProps {
  report: Report;
  isNewest: boolean;
  isBrief: boolean;
}

/** The latest report names its vehicles; older ones show their summary only. */
function ReportItem({ report: { label, answer, isOverdue }, isNewest, isBrief }: ItemProps) {
  if (answer === null && isOverdue) {
    return <Line label={label} outcome={texts.actions.unconfirmed} isRefused testId="results-unconfirmed" />;
  }
  if (answer === null) return <Line label={label} outcome={texts.actions.pending} />;
  if (!answer.ok) return <Line label={label} outcome={answer.message} isRefused testId="results-error" />;
  const results = refusedFirst(answer.value.results);
  const refused = results.filter((result) => !result.accepted).length;
  const outcome =
    results.length === 0 ? texts.actions.accepted : texts.actions.summary(results.length - refused, refused);
  return (
    <>
      <Line label={label} outcome={outcome} isRefused={refused > 0} />
      {isNewest && (
        <ul>
          {(isBrief ? results.slice(0, refused) : results).map((result) => (
            <li
              key={result.vehicle_id}
              class={result.accepted ? "is-done" : "is-refused"}
              data-testid={`result-${result.vehicle_id}`}
              data-accepted={result.accepted}
            >
              <b>{result.vehicle_id}</b>
              {!result.accepted && ` ${texts.actions.refused}`}: {said(result.text)}
            </li>
          ))}
        </ul>
      )}
    </>
  );
}

interface LineProps {
  label: string;
  outcome: string;
  isRefused?: boolean;
  testId?: string;
}

function Line({ label, outcome, isRefused = false, testId }: LineProps) {
  return (
    <p>
      {label}:{" "}
      <b class={isRefused ? "is-refused" : ""} data-testid={testId}>
        {outcome}
      </b>
    </p>
  );
}

function refusedFirst(results: ActionResponse["results"]): ActionResponse["results"] {
  return results.toSorted((a, b) => Number(a.accepted) - Number(b.accepted) || a.vehicle_id - b.vehicle_id);
}
