/** Form that marks a position by its coordinates, for example received by radio. */
import { useState } from "preact/hooks";
import type { Place } from "../../api/types";
import { texts } from "../../texts";
import { PlaceField } from "../../ui/place_field";

export function MarkForm({ onPlace }: { onPlace: (place: Place) => void }) {
  const [place, setPlace] = useState<Place | null>(null);
  return (
    <details class="mark-form">
      <summary data-testid="mark-at">{texts.decide.markAt}</summary>
      <form
        class="form"
        onSubmit={(event) => {
          event.preventDefault();
          if (place !== null) onPlace(place);
        }}
      >
        <PlaceField id="mark-place" label={texts.places.label} value={place} onChange={setPlace} />
        <button type="submit" data-testid="mark-ok" disabled={place === null}>
          {texts.decide.markIt}
        </button>
      </form>
    </details>
  );
}
