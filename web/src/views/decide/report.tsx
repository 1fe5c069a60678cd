/** The report of the mission's findings, made to be printed. */
import type { Finding, Mission } from "../../api/types";
import { boundsOf } from "../../geometry";
import { duration, eastNorth, quantity, words } from "../../format";
import { enu } from "../../map/geojson";
import type { EnuPoint } from "../../state/state";
import { texts } from "../../texts";
import { notations } from "./detail";
import { ellipseText, percent, reported, STATUS_SIGNS } from "./findings";
import "./report.css";
import { Thumbnail } from "./thumbnail";

interface Props {
  mission: Mission;
  onClose(): void;
}

export function Report({ mission, onClose }: Props) {
  const findings = reported(mission.findings);
  const facts: [string, string][] = [
    [texts.report.mission, mission.mission_id],
    [texts.report.printed, new Date().toLocaleString()],
    [texts.header.phase, words(mission.phase)],
    [texts.header.outcome, words(mission.outcome)],
    [texts.header.elapsed, duration(mission.elapsed_s)],
    [texts.plan.strategy, mission.strategy],
    [texts.report.vehicles, String(mission.vehicles.length)],
    [texts.plan.coverage, quantity(mission.covered_percent, 0, "%")],
    [texts.report.findings, String(findings.length)],
  ];
  return (
    <article class="report panel scroll" data-testid="report" aria-label={texts.report.title}>
      <div class="button-row no-print">
        <button type="button" class="primary" data-testid="report-print" onClick={() => window.print()}>
          {texts.report.print}
        </button>
        <button type="button" data-testid="report-close" onClick={onClose}>
          {texts.report.close}
        </button>
      </div>
      <h2>{texts.report.title}</h2>
      <div class="report-head">
        <dl>
          {facts.map(([name, value]) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd>{value}</dd>
            </div>
          ))}
        </dl>
        <Scheme mission={mission} />
      </div>
      {findings.length === 0 && <p>{texts.decide.none.all}</p>}
      {findings.map((finding) => (
        <ReportedFinding key={finding.finding_id} finding={finding} />
      ))}
    </article>
  );
}

function ReportedFinding({ finding }: { finding: Finding }) {
  const { finding_id: id, status, position, sightings, person_confidence, comment, assignee, operator } = finding;
  const facts: [string, string][] = [
    ...notations(finding).map(([name, text]): [string, string] => [texts.decide.notation[name], text]),
    [texts.decide.local, eastNorth(position.east_m, position.north_m)],
    [texts.decide.ellipse, ellipseText(finding)],
    [texts.decide.views, quantity(sightings, 0)],
    [texts.decide.confidence, percent(person_confidence)],
    [texts.decide.found, duration(finding.found_at_s)],
    [texts.decide.seen, duration(finding.seen_at_s)],
    [texts.report.judgedBy, operator],
    [texts.decide.assignee, assignee],
    [texts.decide.comment, comment],
  ];
  return (
    <section class="report-finding" data-testid={`report-finding-${id}`}>
      <h3>
        {texts.decide.finding(id)}: {STATUS_SIGNS[status]} {texts.decide.status[status]}
      </h3>
      <dl>
        {facts
          .filter(([, value]) => value !== "")
          .map(([name, value]) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd>{value}</dd>
            </div>
          ))}
      </dl>
      <Thumbnail finding={finding} kind="integral" />
      <Thumbnail finding={finding} kind="thermal" />
    </section>
  );
}

const MARGIN_M = 15;

/** Area, no-go areas, fence and findings to scale, north up: it prints without a map. */
function Scheme({ mission: { area, fence, no_go, findings } }: { mission: Mission }) {
  const places = [...area, ...fence, ...findings.map(({ position }) => position)].map(enu);
  const bounds = boundsOf(places, MARGIN_M);
  if (bounds === null) return null;
  const [width_m, height_m] = [bounds.east_m - bounds.west_m, bounds.north_m - bounds.south_m];
  const text_m = Math.max(width_m, height_m) / 30;
  const at = ([east_m, north_m]: EnuPoint): EnuPoint => [east_m - bounds.west_m, bounds.north_m - north_m];
  const ring = (corners: readonly EnuPoint[]): string => corners.map((corner) => at(corner).join(",")).join(" ");
  const scale_m = niceLength(width_m / 4);
  return (
    <svg class="scheme" viewBox={`0 0 ${width_m} ${height_m}`} role="img" aria-label={texts.report.scheme}>
      <polygon class="fence" points={ring(fence.map(enu))} />
      <polygon class="area" points={ring(area.map(enu))} />
      {no_go.map((zone, index) => (
        <polygon key={index} class="no-go" points={ring(zone.map(enu))} />
      ))}
      {findings.map(({ finding_id: id, position, status }) => {
        const [x, y] = at(enu(position));
        return (
          <g key={id}>
            <circle cx={x} cy={y} r={text_m / 2.5} />
            <text x={x + text_m / 1.5} y={y + text_m / 3} font-size={text_m}>
              {id} {STATUS_SIGNS[status]}
            </text>
          </g>
        );
      })}
      <path class="scale" d={`M ${text_m} ${height_m - text_m} h ${scale_m}`} />
      <text x={scale_m + 1.5 * text_m} y={height_m - 0.65 * text_m} font-size={text_m}>
        {quantity(scale_m, 0, "m")}
      </text>
    </svg>
  );
}

/** The greatest of 1, 2, 5, 10, 20 … that is not longer. */
function niceLength(length_m: number): number {
  const power = 10 ** Math.floor(Math.log10(length_m));
  return power * ([5, 2].find((factor) => factor * power <= length_m) ?? 1);
}
