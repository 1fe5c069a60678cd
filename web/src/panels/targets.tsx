/** Tracked targets with their estimated positions. */
import type { Target } from "../api/types";
import { eastNorth, latLon, likelihood, quantity } from "../format";
import { texts } from "../texts";
import { Panel } from "../ui/panel";

export function TargetsPanel({ targets }: { targets: readonly Target[] }) {
  return (
    <Panel title={texts.target.panel} testId="targets" class="targets">
      {targets.length === 0 ? <p class="empty">{texts.target.none}</p> : targets.map(TargetFacts)}
    </Panel>
  );
}

function TargetFacts({ track_id: id, position, sigma_m, sightings, person_confidence: person, kind, reasons }: Target) {
  const { latitude_deg: lat, longitude_deg: lon } = position;
  return (
    <dl key={id} data-testid={`target-${id}`}>
      <dt>{texts.map.target(id)}</dt>
      <dd data-testid="target-position">{eastNorth(position.east_m, position.north_m)}</dd>
      {lat !== null && lon !== null && <dd class="small">{latLon(lat, lon)}</dd>}
      <dd class="small">
        {texts.target.error(quantity(sigma_m, 2, "m"))}, {texts.target.sightings(sightings)}
      </dd>
      <dd class="small" data-testid="target-person">
        {texts.target.taken(texts.names.findingKind[kind], likelihood(person))}
      </dd>
      {reasons.length > 0 && <dd class="small">{reasons.join("; ")}</dd>}
    </dl>
  );
}
