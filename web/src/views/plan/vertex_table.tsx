/** Corners of one shape as numbers: exact, and usable without a map. */
import { useState } from "preact/hooks";
import type { Geodetic, Place, Plan } from "../../api/types";
import { toEnu, toLngLat } from "../../geometry";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { NumberField } from "../../ui/number_field";
import { shapeTitle } from "./shape_list";
import {
  inserted,
  isPoint,
  lngLat,
  midpoints,
  noGoIndex,
  placeAt,
  placesOf,
  removed,
  replaced,
  type ShapeName,
  withoutShape,
} from "./shapes";

const UNITS = ["m", "deg"] as const;
type Unit = (typeof UNITS)[number];
/** Coordinates farther from the origin are typing errors: the station accepts areas within five kilometres only. */
const LIMIT_M = 100_000;
const WORLD: Geodetic = { latitude_deg: 0, longitude_deg: 0, altitude_amsl_m: 0 };

interface TableProps {
  plan: Plan;
  shape: ShapeName;
  /** Origin of coordinates in metres; without it only degrees can be given. */
  origin: Geodetic | null;
  vertex: number | null;
  onVertex(vertex: number | null): void;
  onPlaces(places: readonly Place[]): void;
  onPlan(plan: Plan): void;
}

export function VertexTable({ plan, shape, origin, vertex, onVertex, onPlaces, onPlan }: TableProps) {
  const [wanted, setUnit] = useState<Unit>("m");
  const unit = origin === null ? "deg" : wanted;
  const places = placesOf(plan, shape);
  const add = (): void => {
    onPlaces(withNext(places, isPoint(shape), origin ?? WORLD));
    onVertex(places.length);
  };
  const isFull = isPoint(shape) && places.length > 0;
  return (
    <div class="vertices">
      <div class="panel-head">
        <h3>{shapeTitle(shape)}</h3>
        <Choice
          label={texts.plan.units}
          testId="unit"
          values={origin === null ? ["deg"] : UNITS}
          chosen={unit}
          labels={texts.plan.unit}
          onChoose={setUnit}
        />
      </div>
      {places.length > 0 && (
        <table>
          <thead>
            <tr>
              <th scope="col">#</th>
              {texts.plan.axes[unit].map((axis) => (
                <th key={axis} scope="col">
                  {axis}
                </th>
              ))}
              <th scope="col">
                <span class="visually-hidden">{texts.plan.remove}</span>
              </th>
            </tr>
          </thead>
          <tbody>
            {places.map((place, index) => (
              // A corner has no identity other than its index.
              <VertexRow
                key={`${shape}-${index}`}
                place={place}
                index={index}
                unit={unit}
                origin={origin ?? WORLD}
                isChosen={index === vertex}
                onFocus={() => onVertex(index)}
                onChange={(changed) => onPlaces(replaced(places, index, changed))}
                onRemove={() => {
                  onVertex(null);
                  onPlaces(removed(places, index));
                }}
              />
            ))}
          </tbody>
        </table>
      )}
      <div class="button-row">
        <button type="button" data-testid="vertex-add" disabled={isFull} onClick={add}>
          {isPoint(shape) ? texts.plan.setPoint : texts.plan.addCorner}
        </button>
        {(places.length > 0 || noGoIndex(shape) !== null) && (
          <button type="button" data-testid="shape-clear" onClick={() => onPlan(withoutShape(plan, shape))}>
            {texts.plan.removeShape(shapeTitle(shape))}
          </button>
        )}
      </div>
    </div>
  );
}

/** Places with a new one between the last and the first; the first place of a shape is at the origin. */
function withNext(places: readonly Place[], isSingle: boolean, origin: Geodetic): Place[] {
  const middle = midpoints(places).at(-1);
  const last = places.at(-1);
  if (isSingle || last === undefined) return [placeAt([origin.longitude_deg, origin.latitude_deg])];
  return inserted(places, places.length, middle ?? last);
}

interface RowProps {
  place: Place;
  index: number;
  unit: Unit;
  origin: Geodetic;
  isChosen: boolean;
  onFocus(): void;
  onChange(place: Place): void;
  onRemove(): void;
}

function VertexRow({ place, index, unit, origin, isChosen, onFocus, onChange, onRemove }: RowProps) {
  const isMetres = unit === "m";
  const pair = isMetres ? toEnu(origin, lngLat(place)) : ([place.latitude_deg, place.longitude_deg] as const);
  const change = (axis: 0 | 1, value: number | null): void => {
    if (value === null) return;
    const [first, second] = axis === 0 ? [value, pair[1]] : [pair[0], value];
    onChange(isMetres ? placeAt(toLngLat(origin, [first, second])) : { latitude_deg: first, longitude_deg: second });
  };
  const limits = isMetres ? [LIMIT_M, LIMIT_M] : [90, 180];
  return (
    <tr class={isChosen ? "is-chosen" : ""} onFocusCapture={onFocus}>
      <th scope="row">{index + 1}</th>
      {([0, 1] as const).map((axis) => (
        <td key={`${axis}-${unit}`}>
          <NumberField
            label={texts.plan.corner(index + 1, texts.plan.axes[unit][axis])}
            isLabelHidden
            id={`vertex-${index}-${axis}`}
            value={pair[axis]}
            decimals={isMetres ? 1 : 7}
            step={isMetres ? 1 : 1e-5}
            min={-(limits[axis] ?? LIMIT_M)}
            max={limits[axis] ?? LIMIT_M}
            onChange={(value) => change(axis, value)}
          />
        </td>
      ))}
      <td>
        <button
          type="button"
          data-testid={`vertex-remove-${index}`}
          aria-label={texts.plan.removeCorner(index + 1)}
          onClick={onRemove}
        >
          ✕
        </button>
      </td>
    </tr>
  );
}
