/** What became of the last command, vehicle by vehicle. */
import type { ActionAnswer } from "../api/client";
import type { ActionResponse } from "../api/types";
import { texts } from "../texts";

export function Results({ label, answer }: { label: string; answer: ActionAnswer | null }) {
  return (
    <div class="results" data-testid="results" role="status">
      <h2>
        {texts.actions.results}: {label}
      </h2>
      {answer === null && <p>{texts.actions.pending}</p>}
      {answer?.ok === false && (
        <p class="is-refused" data-testid="results-error">
          {answer.message}
        </p>
      )}
      {answer?.ok && (
        <ul>
          {refusedFirst(answer.response.results).map((result) => (
            <li
              key={result.vehicle_id}
              class={result.accepted ? "is-done" : "is-refused"}
              data-testid={`result-${result.vehicle_id}`}
              data-accepted={result.accepted}
            >
              <b>{result.vehicle_id}</b> {result.accepted ? texts.actions.done : texts.actions.refused}: {result.text}
            </li>
          ))}
        </ul>
      )}
    </div>
  );
}

function refusedFirst(results: ActionResponse["results"]): ActionResponse["results"] {
  return results.toSorted((a, b) => Number(a.accepted) - Number(b.accepted) || a.vehicle_id - b.vehicle_id);
}
