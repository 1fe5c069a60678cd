/** Text field for a position in any notation. What is typed stays unchanged until the field is left. */
import { useState } from "preact/hooks";
import type { Place } from "../api/types";
import { readPlace, written } from "../coordinates";
import { useShell } from "../shell/context";
import { texts } from "../texts";

interface Props {
  label: string;
  /** Label for screen readers only, where a column heading says the same. */
  isLabelHidden?: boolean;
  /** Identifier, unique on the page. */
  id: string;
  /** Position, written in the chosen notation; null without one. */
  value: Place | null;
  /** Called with null while the text is not a position. */
  onChange(place: Place | null): void;
}

export function PlaceField({ label, isLabelHidden = false, id, value, onChange }: Props) {
  const { notation } = useShell();
  const [typed, setTyped] = useState<string | null>(null);
  const isUnreadable = typed !== null && typed.trim() !== "" && readPlace(typed) === null;
  return (
    <div class="place-field">
      <label for={id} class={isLabelHidden ? "visually-hidden" : ""}>
        {label}
      </label>
      <input
        id={id}
        type="text"
        data-testid={id}
        autocomplete="off"
        spellcheck={false}
        value={typed ?? (value === null ? "" : written(value, notation))}
        aria-invalid={isUnreadable}
        aria-describedby={`${id}-problem`}
        onInput={({ currentTarget: { value: text } }) => {
          setTyped(text);
          onChange(readPlace(text));
        }}
        onBlur={() => typed !== null && readPlace(typed) !== null && setTyped(null)}
      />
      <p id={`${id}-problem`} class="is-bad field-problem" data-testid={`${id}-problem`}>
        {isUnreadable && texts.places.unreadable}
      </p>
    </div>
  );
}
