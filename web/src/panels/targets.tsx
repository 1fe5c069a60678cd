/** Tracked targets with their estimated positions. */
import type { Target } from "../api/types";
import { type Notation, written } from "../coordinates";
import { eastNorth, likelihood, quantity } from "../format";
import { useShell } from "../shell/context";
import { said, texts } from "../texts";
import { Panel } from "../ui/panel";

export function TargetsPanel({ targets }: { targets: readonly Target[] }) {
  const { notation } = useShell();
  return (
    <Panel title={texts.target.panel} testId="targets" class="targets">
      {targets.length === 0 ? (
        <p class="empty">{texts.target.none}</p>
      ) : (
        targets.map((target) => <TargetFacts key={target.track_id} target={target} notation={notation} />)
      )}
    </Panel>
  );
}

function TargetFacts({ target, notation }: { target: Target; notation: Notation }) {
  const { track_id: id, position, sigma_m, sightings, person_confidence: person, kind, reasons } = target;
  const { latitude_deg: lat, longitude_deg: lon } = position;
  return (
    <dl data-testid={`target-${id}`}>
      <dt>{texts.map.target(id)}</dt>
      {lat !== null && lon !== null && <dd>{written({ latitude_deg: lat, longitude_deg: lon }, notation)}</dd>}
      <dd class="small" data-testid="target-position">
        {eastNorth(position.east_m, position.north_m)}
      </dd>
      <dd class="small">
        {texts.target.error(quantity(sigma_m, 2, "m"))}, {texts.target.sightings(sightings)}
      </dd>
      <dd class="small" data-testid="target-person">
        {texts.target.taken(texts.names.findingKind[kind], likelihood(person))}
      </dd>
      {reasons.length > 0 && <dd class="small">{reasons.map(said).join("; ")}</dd>}
    </dl>
  );
}
