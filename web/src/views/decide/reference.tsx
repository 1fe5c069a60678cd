/** Bearing and distance of a finding, and the place from which they are counted. */
import { useState } from "preact/hooks";
import type { Finding } from "../../api/types";
import { written } from "../../coordinates";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { PlaceField } from "../../ui/place_field";
import { type Reference, wayTo } from "./way";

interface Props {
  finding: Finding;
  reference: Reference;
  isSetting: boolean;
  onChange(place: Reference): void;
  /** Begin or end to wait for a click on the map. */
  onSetOnMap(): void;
}

export function Way({ finding, reference, isSetting, onChange, onSetOnMap }: Props) {
  const { state, notation } = useShell();
  const [isOpen, setOpen] = useState(false);
  const way = state.mission && wayTo(finding, state.mission, reference);
  if (way === null) return null;
  return (
    <div class="way">
      <p>
        <b data-testid="way">{way}</b>{" "}
        <button
          type="button"
          class="inline"
          aria-expanded={isOpen}
          data-testid="way-change"
          onClick={() => setOpen(!isOpen)}
        >
          {texts.decide.changeReference}
        </button>
      </p>
      {reference !== null && <p class="small">{texts.decide.reference(written(reference, notation))}</p>}
      {isOpen && (
        <div class="form">
          <PlaceField
            id="reference-place"
            label={texts.decide.referencePlace}
            value={reference}
            onChange={(place) => place !== null && onChange(place)}
          />
          <div class="button-row">
            <button
              type="button"
              data-testid="reference-map"
              class={isSetting ? "primary" : ""}
              aria-pressed={isSetting}
              onClick={onSetOnMap}
            >
              {isSetting ? texts.decide.marking : texts.decide.setOnMap}
            </button>
            <button
              type="button"
              data-testid="reference-launch"
              disabled={reference === null}
              onClick={() => onChange(null)}
            >
              {texts.decide.useLaunch}
            </button>
          </div>
        </div>
      )}
    </div>
  );
}
