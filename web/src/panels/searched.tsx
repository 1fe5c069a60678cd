/** Progress of the search: share of the area, legs, time left, and how likely a person would have been noticed. */
import type { Mission, Segment } from "../api/types";
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
      {mission.ground !== null && mission.ground.segments.length > 0 && <Segments segments={mission.ground.segments} />}
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

/** Table of the segments: what was seen of each, and how likely a person there would have been noticed. */
function Segments({ segments }: { segments: readonly Segment[] }) {
  return (
    <table class="small segments" data-testid="segments">
      <thead>
        <tr>
          {Object.values(texts.searched.segment).map((title) => (
            <th key={title} scope="col">
              {title}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {segmentRows(segments).map(([name, ...values]) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            {values.map((value, column) => (
              <td key={column}>{value}</td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** Rows of the table of segments: name, seen, detection of a standing person, success by the prior. */
export function segmentRows(segments: readonly Segment[]): readonly (readonly string[])[] {
  const percent = (value: number | null): string => (value === null ? texts.noData : quantity(value, 0, "%"));
  return segments.map((segment) => [
    segment.name,
    percent(segment.seen_percent),
    percent(segment.detection_percent),
    percent(segment.success_percent),
  ]);
}

/** Facts about the search of a mission; those that are not known are left out. */
export function searchedFacts({ ground, legs, leg, covered_percent, scan_left_s }: Mission): readonly Fact[] {
  const percent = (value: number): string => quantity(value, 0, "%");
  const shares = ground?.detection_percent ?? null;
  const soon = ground?.soon_percent ?? null;
  const success = ground?.success_percent ?? null;
  const seen = ground?.seen_percent ?? covered_percent;
  return [
    [texts.searched.seen, seen === null ? "" : percent(seen)],
    [texts.searched.leg, legs.length === 0 ? "" : texts.searched.legOf(Math.min(leg + 1, legs.length), legs.length)],
    [texts.searched.left, scan_left_s === null ? "" : duration(scan_left_s)],
    [texts.searched.standing, shares === null ? "" : percent(shares.standing)],
    [texts.searched.sitting, shares === null ? "" : percent(shares.sitting)],
    [texts.searched.lying, shares === null ? "" : percent(shares.lying)],
    [texts.searched.success, success === null ? "" : percent(success)],
    [texts.searched.soon, shares === null || soon === null ? "" : percent(soon)],
    [texts.searched.views, ground === null ? "" : quantity(ground.mean_views, 1)],
    [texts.searched.leftOut, ground === null || ground.left_out === 0 ? "" : String(ground.left_out)],
  ];
}
