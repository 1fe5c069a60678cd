/** The matrix vehicle x check before the start, with the remedies in words below. */
import type { PreflightCheck } from "../api/types";
import { words } from "../format";
import { texts } from "../texts";

export function PreflightPanel({ checks }: { checks: readonly PreflightCheck[] }) {
  const names = [...new Set(checks.map((check) => check.name))];
  const ids = [...new Set(checks.map((check) => check.vehicle_id))];
  const failed = checks.filter((check) => !check.passed);
  const find = (id: number, name: string) => checks.find((check) => check.vehicle_id === id && check.name === name);
  return (
    <section class="preflight panel" aria-label={texts.preflight.panel} data-testid="preflight">
      <div class="panel-head">
        <h2>{texts.preflight.panel}</h2>
      </div>
      {checks.length === 0 ? (
        <p class="empty">{texts.preflight.none}</p>
      ) : (
        <table>
          <thead>
            <tr>
              <th scope="col">{texts.vehicles.columns.id}</th>
              {names.map((name) => (
                <th key={name} scope="col">
                  {words(name)}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {ids.map((id) => (
              <tr key={id}>
                <th scope="row">{id}</th>
                {names.map((name) => (
                  <Cell key={name} check={find(id, name)} />
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {checks.length > 0 && (
        <ul class="problems" data-testid="preflight-problems">
          {failed.length === 0 && <li class="is-done">{texts.preflight.allPassed}</li>}
          {failed.map((check) => (
            <li key={`${check.vehicle_id} ${check.name}`} class="is-refused">
              <b>{check.vehicle_id}</b> {words(check.name)}: {check.text}
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}

function Cell({ check }: { check: PreflightCheck | undefined }) {
  if (check === undefined) return <td />;
  const word = check.passed ? texts.preflight.passed : texts.preflight.failed;
  return (
    <td class={check.passed ? "is-done" : "is-refused"} title={check.text} aria-label={word}>
      {check.passed ? "✓" : "✗"}
    </td>
  );
}
