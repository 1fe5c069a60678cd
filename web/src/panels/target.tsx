/** Where the target is believed to be. */
import type { Mission } from "../api/types";
import { eastNorth, latLon, quantity } from "../format";
import { texts } from "../texts";

export function Target({ mission }: { mission: Mission | null }) {
  const target = mission?.target;
  return (
    <dl class="target" data-testid="target" aria-label={texts.target.panel}>
      <dt>{texts.target.panel}</dt>
      {target ? <TargetFacts target={target} /> : <dd>{texts.target.none}</dd>}
    </dl>
  );
}

function TargetFacts({ target }: { target: NonNullable<Mission["target"]> }) {
  const { position, sigma_m, sightings } = target;
  const { latitude_deg: lat, longitude_deg: lon } = position;
  return (
    <>
      <dd data-testid="target-position">{eastNorth(position.east_m, position.north_m)}</dd>
      {lat !== null && lon !== null && <dd class="small">{latLon(lat, lon)}</dd>}
      <dd class="small">
        {texts.target.sigma} {quantity(sigma_m, 2, "m")}, {texts.target.sightings(sightings)}
      </dd>
    </>
  );
}
