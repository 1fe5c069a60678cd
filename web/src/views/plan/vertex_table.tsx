/** Corners of one shape as numbers: exact, and usable without a map. */
import { useState } from "preact/hooks";
import type { Geodetic, Place, Plan } from "../../api/types";
import { lngLat, placeAt, toEnu, toLngLat } from "../../geometry";
import type { EnuPoint } from "../../state/state";
import { readStored, store } from "../../storage";
import { texts } from "../../texts";
import { Choice } from "../../ui/choice";
import { NumberField } from "../../ui/number_field";
import { PlaceField } from "../../ui/place_field";
import { shapeTitle } from "./shape_list";
import {
  inserted,
  isPoint,
  midpoints,
  noGoIndex,
  placesOf,
  removed,
  replaced,
  type ShapeName,
  withoutShape,
} from "./shapes";

const UNITS = ["m", "globe"] as const;
type Unit = (typeof UNITS)[number];
const KEY = "aos-gcs-corners";
const storedUnit = (): Unit => UNITS.find((unit) => unit === readStored(KEY)) ?? "m";
/** Coordinates farther from the origin are typing errors: the station accepts areas within five kilometres only. */
const LIMIT_M = 100_000;
const WORLD: Geodetic = { latitude_deg: 0, longitude_deg: 0, altitude_amsl_m: 0 };

interface TableProps {
  plan: Plan;
  shape: ShapeName;
  /** Origin of coordinates in metres; without it only places on the globe can be given. */
  origin: Geodetic | null;
  vertex: number | null;
  /** Observers read the corners, in metres or as coordinates. */
  mayChange: boolean;
  onVertex(vertex: number | null): void;
  onPlaces(places: readonly Place[]): void;
  onPlan(plan: Plan): void;
}

export function VertexTable({ plan, shape, origin, vertex, mayChange, onVertex, onPlaces, onPlan }: TableProps) {
  const [wanted, setWanted] = useState(storedUnit);
  const setUnit = (chosen: Unit): void => {
    store(KEY, chosen);
    setWanted(chosen);
  };
  const unit = origin === null ? "globe" : wanted;
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
          values={origin === null ? ["globe"] : UNITS}
          chosen={unit}
          labels={texts.plan.unit}
          onChoose={setUnit}
        />
      </div>
      <fieldset disabled={!mayChange}>
        {places.length > 0 && (
          <table>
            <thead>
              <tr>
                <th scope="col">#</th>
                {(unit === "m" ? texts.plan.axes : [texts.plan.unit.globe]).map((column) => (
                  <th key={column} scope="col">
                    {column}
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
                  origin={unit === "m" ? origin : null}
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
      </fieldset>
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
  /** Origin of coordinates in metres; null for places on the globe. */
  origin: Geodetic | null;
  isChosen: boolean;
  onFocus(): void;
  onChange(place: Place): void;
  onRemove(): void;
}

function VertexRow({ place, index, origin, isChosen, onFocus, onChange, onRemove }: RowProps) {
  return (
    <tr class={isChosen ? "is-chosen" : ""} onFocusCapture={onFocus}>
      <th scope="row">{index + 1}</th>
      {origin === null ? (
        <td>
          <PlaceField
            label={texts.plan.corner(index + 1, texts.plan.unit.globe)}
            isLabelHidden
            id={`vertex-${index}`}
            value={place}
            onChange={(changed) => changed !== null && onChange(changed)}
          />
        </td>
      ) : (
        <MetreCells place={place} index={index} origin={origin} onChange={onChange} />
      )}
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

interface CellProps {
  place: Place;
  index: number;
  origin: Geodetic;
  onChange(place: Place): void;
}

function MetreCells({ place, index, origin, onChange }: CellProps) {
  const [east_m, north_m] = toEnu(origin, lngLat(place));
  const change = (moved: EnuPoint): void => onChange(placeAt(toLngLat(origin, moved)));
  return texts.plan.axes.map((axis, side) => (
    <td key={axis}>
      <NumberField
        label={texts.plan.corner(index + 1, axis)}
        isLabelHidden
        id={`vertex-${index}-${side}`}
        value={side === 0 ? east_m : north_m}
        decimals={1}
        min={-LIMIT_M}
        max={LIMIT_M}
        onChange={(value) => value !== null && change(side === 0 ? [value, north_m] : [east_m, value])}
      />
    </td>
  ));
}
