/** Profile of one leg of the plan: the ground, the canopy, the altitude layers, and the limits. */
import { useRef } from "preact/hooks";
import type { PlanReport } from "../../api/types";
import { quantity } from "../../format";
import { texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { useSize } from "../../ui/use_size";
import "./profile.css";
import {
  bandPath,
  clearanceOf,
  heightPx,
  heightTicks,
  linePath,
  type ProfileLines,
  profileLines,
  scaleOf,
} from "./profile_lines";

/** Room for the labels of the axes. */
const [LEFT_PX, BOTTOM_PX] = [44, 16];
const UNMEASURED = { width_px: 600, height_px: 130 };
/** Rows of the table of numbers. */
const ROWS = 9;

interface Props {
  report: PlanReport | null;
  /** Index of the leg that is shown. */
  leg: number;
  isChecking: boolean;
  onLeg(leg: number): void;
}

export function ProfilePanel({ report, leg: wanted, isChecking, onLeg }: Props) {
  const legs = (report?.profile ?? []).map((profile) =>
    profileLines(profile, report?.layers_m ?? [], report?.canopy_height_m ?? null),
  );
  const leg = Math.min(wanted, legs.length - 1);
  const shown = legs[leg];
  return (
    <Panel
      title={texts.plan.profile.panel}
      testId="plan-profile"
      class="plan-profile"
      aside={
        legs.length > 0 && (
          <select
            data-testid="profile-leg"
            aria-label={texts.plan.profile.choose}
            value={leg}
            onChange={(event) => onLeg(Number(event.currentTarget.value))}
          >
            {legs.map((_, index) => (
              <option key={index} value={index}>
                {texts.plan.profile.leg(index + 1, legs.length)}
              </option>
            ))}
          </select>
        )
      }
    >
      {shown === undefined ? (
        <p class="empty">{texts.plan.profile.none}</p>
      ) : (
        <figure class={isChecking ? "is-old" : ""}>
          <Chart legs={legs} shown={shown} />
          <figcaption>
            <Summary shown={shown} />
            <Legend hasCanopy={shown.canopy_m !== null} />
          </figcaption>
          <Numbers shown={shown} />
        </figure>
      )}
    </Panel>
  );
}

function Summary({ shown }: { shown: ProfileLines }) {
  const { lowest_m, highest_m, isBelowFloor, isAboveCeiling } = clearanceOf(shown);
  const isBad = isBelowFloor || isAboveCeiling;
  const { summary, belowFloor, aboveCeiling } = texts.plan.profile;
  const text = summary(
    quantity(shown.distances_m.at(-1), 0, "m"),
    quantity(lowest_m, 1, "m"),
    quantity(highest_m, 1, "m"),
  );
  return (
    <p data-testid="profile-summary" class={isBad ? "is-bad" : ""}>
      {[text, ...(isBelowFloor ? [belowFloor] : []), ...(isAboveCeiling ? [aboveCeiling] : [])].join(" ")}
    </p>
  );
}

function Legend({ hasCanopy }: { hasCanopy: boolean }) {
  const names = texts.plan.profile.line;
  const shown = (["ceiling", "layers", "floor", "canopy", "ground"] as const).filter(
    (one) => one !== "canopy" || hasCanopy,
  );
  return (
    <ul class="profile-legend" aria-hidden="true">
      {shown.map((name) => (
        <li key={name} class={`of-${name}`}>
          {names[name]}
        </li>
      ))}
    </ul>
  );
}

function Chart({ legs, shown }: { legs: readonly ProfileLines[]; shown: ProfileLines }) {
  const frame = useRef<HTMLDivElement>(null);
  const { width_px, height_px } = useSize(frame) ?? UNMEASURED;
  const inner = { width_px: Math.max(1, width_px - LEFT_PX), height_px: Math.max(1, height_px - BOTTOM_PX) };
  const scale = scaleOf(legs, shown, inner);
  const { distances_m: at, lowestGround_m: low, highestGround_m: high } = shown;
  const bottom = at.map(() => scale.bottom_m);
  const path = (heights_m: readonly (number | null)[]): string => linePath(at, heights_m, scale);
  return (
    <div class="profile-chart" ref={frame}>
      <svg width={width_px} height={height_px} role="img" aria-label={texts.plan.profile.chart}>
        <g transform={`translate(${LEFT_PX} 0)`}>
          {heightTicks(scale).map((height_m) => (
            <g key={height_m} class="tick" transform={`translate(0 ${heightPx(height_m, scale).toFixed(1)})`}>
              <line x2={inner.width_px} />
              <text x="-4" dy="0.35em" text-anchor="end">
                {quantity(height_m, 0, "m")}
              </text>
            </g>
          ))}
          <path class="of-ground-band" d={bandPath(at, low, high, scale)} />
          <path class="of-ground" d={bandPath(at, bottom, low, scale)} />
          {shown.canopy_m && <path class="of-canopy" d={path(shown.canopy_m)} />}
          <path class="of-floor" d={path(shown.floor_m)} />
          <path class="of-ceiling" d={path(shown.ceiling_m)} />
          {shown.layers_m.map((layer_m, index) => (
            <path key={index} class="of-layers" d={path(layer_m)} />
          ))}
          <text class="axis" x="0" y={height_px - 3}>
            {texts.plan.profile.start}
          </text>
          <text class="axis" x={inner.width_px} y={height_px - 3} text-anchor="end">
            {quantity(scale.length_m, 0, "m")}
          </text>
        </g>
      </svg>
    </div>
  );
}

/** The same in numbers, for screen readers and for who wants them. */
function Numbers({ shown }: { shown: ProfileLines }) {
  const last = shown.distances_m.length - 1;
  const count = Math.min(ROWS, last + 1);
  const rows = Array.from({ length: count }, (_, row) => Math.round((row * last) / Math.max(1, count - 1)));
  const { columns } = texts.plan.profile;
  const metres = (height_m: number | null | undefined): string => quantity(height_m, 0, "m");
  return (
    <details>
      <summary data-testid="profile-numbers">{texts.plan.profile.numbers}</summary>
      <div class="scroll" tabIndex={0} role="region" aria-label={texts.plan.profile.numbers}>
        <table>
          <thead>
            <tr>
              {columns.map((name) => (
                <th key={name} scope="col">
                  {name}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <tr key={row}>
                <th scope="row">{metres(shown.distances_m[row])}</th>
                <td>{`${metres(shown.lowestGround_m[row])} – ${metres(shown.highestGround_m[row])}`}</td>
                <td>{metres(shown.floor_m[row])}</td>
                <td>{metres(shown.layers_m[0]?.[row])}</td>
                <td>{metres(shown.layers_m.at(-1)?.[row])}</td>
                <td>{metres(shown.ceiling_m[row])}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}
