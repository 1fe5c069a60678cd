/** Relay of batteries: which vehicle leaves for home when, and which ones on the ground may take its place. */
import type { Mission, Vehicle } from "../api/types";
import { duration } from "../format";
import { texts } from "../texts";
import { type Fact, Facts } from "../ui/facts";
import { Panel } from "../ui/panel";

export function RelayPanel({ mission }: { mission: Mission | null }) {
  const facts = mission === null ? [] : relayFacts(mission.vehicles);
  if (facts.length === 0) return null;
  return (
    <Panel title={texts.relay.panel} testId="relay" class="relay">
      <Facts facts={facts} class="rows" />
    </Panel>
  );
}

/** Facts about the relay: departures, the next one first, and the vehicles on the ground. */
export function relayFacts(vehicles: readonly Vehicle[]): readonly Fact[] {
  const leaving = vehicles
    .flatMap(({ vehicle_id, leaves_in_s }) => (leaves_in_s === null ? [] : [{ vehicle_id, leaves_in_s }]))
    .sort((one, other) => one.leaves_in_s - other.leaves_in_s);
  const departures = leaving.map(({ vehicle_id, leaves_in_s }, index): Fact => {
    const label = index === 0 ? texts.relay.next(vehicle_id) : texts.vehicle.panel(vehicle_id);
    return [label, leaves_in_s <= 0 ? texts.relay.due : texts.relay.leavesIn(duration(leaves_in_s))];
  });
  const waiting = vehicles.flatMap(({ vehicle_id, relay_ready }): Fact[] =>
    relay_ready === null
      ? []
      : [[texts.vehicle.panel(vehicle_id), relay_ready ? texts.relay.ready : texts.relay.unconfirmed]],
  );
  return [...departures, ...waiting];
}
