/** Sorties of the operation, with the choice of the one that a replay shows. */
import { useEffect, useState } from "preact/hooks";
import { readOperation } from "../../api/operation";
import { controlReplay } from "../../api/replay";
import type { Mission, Sortie } from "../../api/types";
import { duration, quantity, timeOfDay } from "../../format";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";

interface Props {
  mission: Mission;
  /** Whether this page may choose what is replayed: operators only. */
  mayControl: boolean;
}

/** Nothing for a mission that is the only sortie of its operation. */
export function Sorties({ mission, mayControl }: Props) {
  const { mission_id: shownId, phase } = mission;
  const [sorties, setSorties] = useState<readonly Sortie[]>([]);
  const [problem, setProblem] = useState("");
  // A phase that begins or ends changes what the record of the shown mission tells.
  useEffect(() => {
    void readOperation().then((answer) => setSorties(answer.ok ? answer.value.sorties : []));
  }, [shownId, phase]);
  if (sorties.length < 2) return null;

  const { sorties: labels, sortieColumn: column } = texts.understand;
  const show = (missionId: string): void => {
    void controlReplay({ mission_id: missionId }).then((answer) => setProblem(answer.ok ? "" : answer.message));
  };
  return (
    <Panel title={labels.panel} testId="sorties">
      <div class="scroll" tabIndex={0}>
        <table class="number-table">
          <thead>
            <tr>
              {Object.values(column).map((name) => (
                <th key={name} scope="col">
                  {name}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {sorties.map((sortie) => (
              <tr key={sortie.mission_id} aria-current={sortie.mission_id === shownId ? "true" : undefined}>
                <th scope="row">{sortie.number}</th>
                <td>{timeOfDay(sortie.start_utc_s)}</td>
                <td>{duration(sortie.duration_s)}</td>
                <td>{texts.names.outcome[sortie.outcome]}</td>
                <td>{quantity(sortie.covered_percent, 0, "%")}</td>
                <td>{labels.findings(sortie.findings, sortie.confirmed)}</td>
                <td>{sortie.folder}</td>
                <td>
                  {sortie.mission_id === shownId ? (
                    labels.shown
                  ) : mission.replay !== null && mayControl ? (
                    <button
                      type="button"
                      data-testid={`show-sortie-${sortie.number}`}
                      onClick={() => show(sortie.mission_id)}
                    >
                      {labels.show}
                    </button>
                  ) : null}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {mission.replay === null && <p class="small">{labels.hint}</p>}
      {problem !== "" && (
        <p class="is-bad" role="alert">
          {problem}
        </p>
      )}
    </Panel>
  );
}
