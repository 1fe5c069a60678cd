/** Sketch to scale of search area, no-go zones, geofence and findings, north up, which prints without a map. */
import type { ComponentChildren } from "preact";
import type { Finding, Mission } from "../../api/types";
import { quantity } from "../../format";
import { boundsOf, ellipse } from "../../geometry";
import { enu } from "../../map/geojson";
import { useShell } from "../../shell/context";
import type { EnuPoint } from "../../state/state";
import { texts } from "../../texts";
import { STATUS_SIGNS } from "./findings";

const MARGIN_M = 15;

export function Sketch({ mission: { area, fence, no_go, findings } }: { mission: Mission }) {
  const { isSurvey } = useShell();
  const places = [...area, ...fence, ...findings.map(({ position }) => position)].map(enu);
  const bounds = boundsOf(places, MARGIN_M);
  if (bounds === null) return null;
  const [width_m, height_m] = [bounds.east_m - bounds.west_m, bounds.north_m - bounds.south_m];
  const text_m = Math.max(width_m, height_m) / 30;
  const at = ([east_m, north_m]: EnuPoint): EnuPoint => [east_m - bounds.west_m, bounds.north_m - north_m];
  const ring = (corners: readonly EnuPoint[]): string => corners.map((corner) => at(corner).join(",")).join(" ");
  const scale_m = niceLength(width_m / 4);
  const legend: (keyof typeof texts.report.legend)[] = [
    ...(area.length > 0 ? (["area"] as const) : []),
    ...(fence.length > 0 ? (["fence"] as const) : []),
    ...(no_go.length > 0 ? (["no-go"] as const) : []),
  ];
  return (
    <figure class="sketch">
      <svg viewBox={`0 0 ${width_m} ${height_m}`} role="img" aria-label={texts.report.sketch}>
        <polygon class="fence" points={ring(fence.map(enu))} />
        <polygon class="area" points={ring(area.map(enu))} />
        {no_go.map((zone, index) => (
          <polygon key={index} class="no-go" points={ring(zone.map(enu))} />
        ))}
        {findings.map((finding) => (
          <Mark key={finding.finding_id} finding={finding} place={at(enu(finding.position))} text_m={text_m}>
            {finding.ellipse && <polygon points={ring(ellipse(enu(finding.position), finding.ellipse))} />}
          </Mark>
        ))}
        <path d={`M ${text_m} ${height_m - text_m} h ${scale_m}`} />
        <text x={scale_m + 1.5 * text_m} y={height_m - 0.65 * text_m} font-size={text_m}>
          {quantity(scale_m, 0, "m")}
        </text>
        <path
          d={`M ${text_m * 1.5} ${text_m * 4} v ${-2.5 * text_m} l ${-0.5 * text_m} ${text_m} m ${0.5 * text_m} ${-text_m} l ${0.5 * text_m} ${text_m}`}
        />
        <text x={text_m * 2.2} y={text_m * 2.2} font-size={text_m}>
          {texts.plan.north}
        </text>
      </svg>
      <figcaption>
        {legend.map((name) => (
          <span key={name}>
            <i class={name} />
            {isSurvey && name === "area" ? texts.survey.area : texts.report.legend[name]}
          </span>
        ))}
      </figcaption>
    </figure>
  );
}

interface MarkProps {
  finding: Finding;
  place: EnuPoint;
  text_m: number;
  /** Error ellipse. */
  children: ComponentChildren;
}

function Mark({ finding: { finding_id: id, status }, place: [x, y], text_m, children }: MarkProps) {
  return (
    <g>
      {children}
      <circle cx={x} cy={y} r={text_m / 2.5} />
      <text x={x + text_m / 1.5} y={y + text_m / 3} font-size={text_m}>
        {id} {STATUS_SIGNS[status]}
      </text>
    </g>
  );
}

/** Largest of 1, 2, 5, 10, 20 … that is not longer. */
function niceLength(length_m: number): number {
  const power = 10 ** Math.floor(Math.log10(length_m));
  return power * ([5, 2].find((factor) => factor * power <= length_m) ?? 1);
}
