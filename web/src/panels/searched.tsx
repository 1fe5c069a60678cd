/** Progress of the search: share of the area, legs, time left, and how likely a person would have been noticed. */
import type { Mission } from "../api/types";
import { duration, quantity } from "../format";
import { texts } from "../texts";
import { type Fact, Facts } from "../ui/facts";
import { Panel } from "../ui/panel";

/** Files of the searched ground, by their suffix. */
const FILES = ["tif", "geojson"] as const;

interface Props {
  mission: Mission | null;
  /** Whether the station has the record at hand. */
  hasFiles: boolean;
}

export function SearchedPanel({ mission, hasFiles }: Props) {
  if (mission === null || (mission.ground === null && mission.legs.length === 0)) return null;
  return (
    <Panel title={texts.searched.panel} testId="searched" class="searched">
      <Facts facts={searchedFacts(mission)} class="rows" />
      {hasFiles && mission.ground?.detection_percent && (
        <div class="button-row">
          {FILES.map((suffix) => (
            <a key={suffix} class="button" href={`/api/ground.${suffix}`} download data-testid={`ground-${suffix}`}>
              {texts.searched.file[suffix]}
            </a>
          ))}
        </div>
      )}
    </Panel>
  );
}

/** Facts about the search of a mission; those that are not known are left out. */
export function searchedFacts({ ground, legs, leg, covered_percent, scan_left_s }: Mission): readonly Fact[] {
  const percent = (value: number): string => quantity(value, 0, "%");
  const shares = ground?.detection_percent ?? null;
  const soon = ground?.soon_percent ?? null;
  const seen = ground?.seen_percent ?? covered_percent;
  return [
    [texts.searched.seen, seen === null ? "" : percent(seen)],
    [texts.searched.leg, legs.length === 0 ? "" : texts.searched.legOf(Math.min(leg + 1, legs.length), legs.length)],
    [texts.searched.left, scan_left_s === null ? "" : duration(scan_left_s)],
    [texts.searched.standing, shares === null ? "" : percent(shares.standing)],
    [texts.searched.sitting, shares === null ? "" : percent(shares.sitting)],
    [texts.searched.lying, shares === null ? "" : percent(shares.lying)],
    [texts.searched.soon, shares === null || soon === null ? "" : percent(soon)],
    [texts.searched.views, ground === null ? "" : quantity(ground.mean_views, 1)],
    [texts.searched.leftOut, ground === null || ground.left_out === 0 ? "" : String(ground.left_out)],
  ];
}
