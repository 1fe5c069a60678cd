/** Form that marks a position by its coordinates, for example received by radio. */
import { useState } from "preact/hooks";
import type { Place } from "../../api/types";
import { texts } from "../../texts";
import { NumberField } from "../../ui/number_field";

export function MarkForm({ onPlace }: { onPlace: (place: Place) => void }) {
  const [latitude_deg, setLatitude] = useState<number | null>(null);
  const [longitude_deg, setLongitude] = useState<number | null>(null);
  const isComplete = latitude_deg !== null && longitude_deg !== null;
  return (
    <details class="mark-form">
      <summary data-testid="mark-at">{texts.decide.markAt}</summary>
      <form
        class="field-grid"
        onSubmit={(event) => {
          event.preventDefault();
          if (isComplete) onPlace({ latitude_deg, longitude_deg });
        }}
      >
        <NumberField
          id="mark-latitude"
          label={texts.decide.latitude}
          unit="°"
          value={latitude_deg}
          decimals={7}
          min={-90}
          max={90}
          step={1e-5}
          onChange={setLatitude}
        />
        <NumberField
          id="mark-longitude"
          label={texts.decide.longitude}
          unit="°"
          value={longitude_deg}
          decimals={7}
          min={-180}
          max={180}
          step={1e-5}
          onChange={setLongitude}
        />
        <button type="submit" data-testid="mark-ok" disabled={!isComplete}>
          {texts.decide.markIt}
        </button>
      </form>
    </details>
  );
}
