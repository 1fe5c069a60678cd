/** Tracked targets with their estimated positions, and places that are left for a later look. */
import type { LeftPlace, Target } from "../api/types";
import { type Notation, written } from "../coordinates";
import { eastNorth, likelihood, quantity } from "../format";
import { useShell } from "../shell/context";
import { said, texts } from "../texts";
import { Panel } from "../ui/panel";

interface TargetsProps {
  targets: readonly Target[];
  later: readonly LeftPlace[];
}

export function TargetsPanel({ targets, later }: TargetsProps) {
  const { notation } = useShell();
  return (
    <Panel title={texts.target.panel} testId="targets" class="targets">
      {targets.length === 0 ? (
        <p class="empty">{texts.target.none}</p>
      ) : (
        targets.map((target) => <TargetFacts key={target.track_id} target={target} notation={notation} />)
      )}
      {later.length > 0 && (
        <dl data-testid="left-for-later">
          <dt>{texts.target.later}</dt>
          {later.map(({ position, person_confidence: person }) => (
            <dd class="small" key={`${position.east_m},${position.north_m}`}>
              {eastNorth(position.east_m, position.north_m)}, {texts.target.person(likelihood(person))}
            </dd>
          ))}
        </dl>
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
