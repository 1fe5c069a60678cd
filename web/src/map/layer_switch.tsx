/** Selection of the visible layers, and of the image on the ground. */
import { useState } from "preact/hooks";
import type { PictureKind } from "../api/types";
import { texts } from "../texts";
import { chooseBasemap, forgetBasemap, SUFFIX, useChosenBasemap } from "./chosen_basemap";
import type { MapLayer, Overlay } from "./layer";

type LayerName = keyof typeof texts.map.layer;
const isSwitchable = (id: string): id is LayerName => Object.hasOwn(texts.map.layer, id);

const kinds = (): PictureKind[] => Object.keys(texts.names.picture) as PictureKind[];
const OPACITY = 0.85;

export interface LayerChoice {
  readonly hidden: ReadonlySet<string>;
  readonly kind: PictureKind | null;
  readonly opacity: number;
}

const FIRST_CHOICE: LayerChoice = { hidden: new Set(["heights"]), kind: "integral", opacity: OPACITY };

/** Latest choice, which a view shows when it is opened again. */
let lastChoice = FIRST_CHOICE;

/** Current choice and a function that changes it. */
export function useLayerChoice(): [LayerChoice, (choice: LayerChoice) => void] {
  const [choice, setChoice] = useState(lastChoice);
  const change = (chosen: LayerChoice): void => {
    lastChoice = chosen;
    setChoice(chosen);
  };
  return [choice, change];
}

export const shownOf = (layers: readonly MapLayer[], { hidden }: LayerChoice): MapLayer[] =>
  layers.filter((layer) => !hidden.has(layer.id));
export const overlayOf = ({ kind, opacity }: LayerChoice): Overlay | null => (kind === null ? null : { kind, opacity });

interface Props {
  /** Layers, bottom up; those with a name in the texts can be switched. */
  layers: readonly MapLayer[];
  choice: LayerChoice;
  /** Whether the view shows images on the ground. */
  hasPicture?: boolean;
  onChange(choice: LayerChoice): void;
}

export function LayerSwitch({ layers, choice, hasPicture = true, onChange }: Props) {
  const [isOpen, setOpen] = useState(false);
  const names = layers
    .map((layer) => layer.id)
    .filter(isSwitchable)
    .reverse();
  const toggle = (name: LayerName): void => {
    const hidden = new Set(choice.hidden);
    if (!hidden.delete(name)) hidden.add(name);
    onChange({ ...choice, hidden });
  };
  return (
    <div class="layer-switch">
      <button type="button" data-testid="map-layers" aria-expanded={isOpen} onClick={() => setOpen(!isOpen)}>
        {texts.map.layers}
      </button>
      {isOpen && (
        <div class="layer-list" role="group" aria-label={texts.map.layers}>
          {hasPicture && <PictureChoice choice={choice} onChange={onChange} />}
          {names.map((name) => (
            <label key={name}>
              <input
                type="checkbox"
                data-testid={`layer-${name}`}
                checked={!choice.hidden.has(name)}
                onChange={() => toggle(name)}
              />
              {texts.map.layer[name]}
            </label>
          ))}
          <BasemapChoice />
        </div>
      )}
    </div>
  );
}

/** Choice of a base map from a file of this computer. */
function BasemapChoice() {
  const { chosen, refusal } = useChosenBasemap();
  return (
    <>
      <label class="file-picker">
        {texts.map.chooseBasemap}
        <input
          type="file"
          accept={SUFFIX}
          data-testid="basemap-file"
          onChange={({ currentTarget }) => {
            const [file] = currentTarget.files ?? [];
            if (file) void chooseBasemap(file);
            currentTarget.value = ""; // lets the operator pick the same file again
          }}
        />
      </label>
      {chosen && (
        <button type="button" data-testid="basemap-forget" onClick={forgetBasemap}>
          {texts.map.forgetBasemap(chosen.name)}
        </button>
      )}
      <p class="is-bad small" role="alert" data-testid="basemap-refusal">
        {refusal}
      </p>
    </>
  );
}

/** Selection of the image on the ground, and of its opacity. */
function PictureChoice({ choice, onChange }: Pick<Props, "choice" | "onChange">) {
  return (
    <>
      <label>
        {texts.map.picture}
        <select
          data-testid="map-picture"
          value={choice.kind ?? ""}
          onChange={(event) => {
            const kind = kinds().find((one) => one === event.currentTarget.value) ?? null;
            onChange({ ...choice, kind });
          }}
        >
          <option value="">{texts.map.noPicture}</option>
          {kinds().map((kind) => (
            <option key={kind} value={kind}>
              {texts.names.picture[kind]}
            </option>
          ))}
        </select>
      </label>
      <label>
        {texts.map.opacity}
        <input
          type="range"
          min="0"
          max="1"
          step="0.05"
          data-testid="map-opacity"
          disabled={choice.kind === null}
          value={choice.opacity}
          onInput={(event) => onChange({ ...choice, opacity: Number(event.currentTarget.value) })}
        />
      </label>
    </>
  );
}
