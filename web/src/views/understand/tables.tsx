/** Values of the charts as tables, for screen readers and for exact numbers. */
import type { Mission, StepFigures, Vehicle } from "../../api/types";
import { age, displayName, duration, quantity, UNKNOWN } from "../../format";
import { isStale, linkAge_s } from "../../state/freshness";
import { texts } from "../../texts";

/** Rows of the table of steps: those of hours, each time a step is added, would keep the page busy. */
const STEPS_SHOWN = 200;

export function StepTable({ steps }: { steps: readonly StepFigures[] }) {
  const { column, stepTable } = texts.understand;
  const shown = steps.slice(-STEPS_SHOWN).reverse();
  return (
    <div class="scroll panel" tabIndex={0}>
      <table class="number-table" data-testid="step-table">
        <caption>{stepTable(shown.length, steps.length)}</caption>
        <Head names={Object.values(column)} />
        <tbody>
          {shown.map((step) => (
            <tr key={step.step}>
              <th scope="row">{step.step}</th>
              <td>{duration(step.elapsed_s)}</td>
              <td>{quantity(step.visibility_m2, 2)}</td>
              <td>{quantity(step.threshold_m2, 2)}</td>
              <td>{displayName(texts.names.branch, step.branch)}</td>
              <td>{quantity(step.evolutionary_factor, 2)}</td>
              <td>{stateName(step)}</td>
              <td>{quantity(step.c_s_m, 2)}</td>
              <td>{quantity(step.c_c_m, 2)}</td>
              <td>{step.leader_id ?? UNKNOWN}</td>
              <td>{quantity(step.imaging_ms, 0)}</td>
              <td>{quantity(step.work_ms, 0)}</td>
              <td>{quantity(step.loop_lag_p99_ms, 0)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function LinkTable({ mission, snapshotAge_s }: { mission: Mission; snapshotAge_s: number }) {
  const { linkColumn, linkTable } = texts.understand;
  return (
    <div class="scroll panel" tabIndex={0}>
      <table class="number-table" data-testid="link-table">
        <caption>{linkTable}</caption>
        <Head names={Object.values(linkColumn)} />
        <tbody>
          {mission.vehicles.map((vehicle) => (
            <LinkRows key={vehicle.vehicle_id} vehicle={vehicle} snapshotAge_s={snapshotAge_s} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** The autopilot's link, and one row for each other component: these do not show that the autopilot is heard. */
function LinkRows({ vehicle, snapshotAge_s }: { vehicle: Vehicle; snapshotAge_s: number }) {
  return (
    <>
      <tr class={isStale(vehicle, snapshotAge_s) ? "is-stale" : ""}>
        <th scope="row">{vehicle.vehicle_id}</th>
        <td>{quantity(vehicle.packet_loss_percent, 1, "%")}</td>
        <td>{quantity(vehicle.link?.round_trip_ms, 0, "ms")}</td>
        <td>{age(linkAge_s(vehicle, snapshotAge_s))}</td>
        <td>{vehicle.link?.address ?? UNKNOWN}</td>
      </tr>
      {vehicle.components.map(({ component_id, name, age_s }) => (
        <tr key={component_id}>
          <th scope="row">{texts.understand.component(vehicle.vehicle_id, name || `${component_id}`)}</th>
          <td />
          <td />
          <td>{age(age_s === null ? null : age_s + snapshotAge_s)}</td>
          <td />
        </tr>
      ))}
    </>
  );
}

const stateName = ({ evolutionary_state: state }: StepFigures): string =>
  state === null ? UNKNOWN : displayName(texts.names.evolutionaryState, state);

function Head({ names }: { names: readonly string[] }) {
  return (
    <thead>
      <tr>
        {names.map((name) => (
          <th key={name} scope="col">
            {name}
          </th>
        ))}
      </tr>
    </thead>
  );
}
