/** Number field with its unit. What is typed stays unchanged until the field is left; problems are shown below it. */
import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { texts } from "../texts";
import { shownUnit } from "../units";

/** Stands for typed text that is not a number, which the browser does not disclose. */
const UNREADABLE = "?";

interface Props {
  label: string;
  /** Label for screen readers only, where a column heading says the same. */
  isLabelHidden?: boolean;
  /** Metric unit of the value; it is shown and typed in the units of this screen. */
  unit?: string;
  /** Identifier, unique on the page; other parts can move the focus to it. */
  id: string;
  /** Null without a value; `placeholder` then says what applies. */
  value: number | null;
  decimals: number;
  min?: number;
  max?: number;
  step?: number;
  placeholder?: string;
  isOptional?: boolean;
  /** Problem of the value. */
  problem?: string | undefined;
  /** Advice about the value. */
  advice?: string | undefined;
  onChange(value: number | null): void;
  /** Content below the field. */
  children?: ComponentChildren;
}

export function NumberField({ label, id, decimals, isOptional = false, ...props }: Props) {
  const { placeholder, problem, advice, isLabelHidden = false, children } = props;
  const { unit, value, min, max, step, onChange } = inShownUnit(props);
  const [typed, setTyped] = useState<string | null>(null);
  const issue = typed === null ? null : typedIssue(typed, isOptional, min, max);
  const shown = issue ?? problem;
  const written = value === null ? "" : String(Number(value.toFixed(decimals)));
  const type = (text: string): void => {
    setTyped(text);
    if (typedIssue(text, isOptional, min, max) === null) onChange(text === "" ? null : Number(text));
  };
  return (
    <div class="number-field">
      <label for={id} class={isLabelHidden ? "visually-hidden" : ""}>
        {label}
      </label>
      <span class="number-input">
        <input
          id={id}
          type="number"
          inputMode="decimal"
          data-testid={id}
          min={min}
          max={max}
          step="any"
          required={!isOptional}
          placeholder={placeholder}
          value={typed === UNREADABLE ? undefined : (typed ?? written)}
          aria-invalid={shown !== undefined}
          aria-describedby={`${id}-problem`}
          onInput={(event) => type(event.currentTarget.validity.badInput ? UNREADABLE : event.currentTarget.value)}
          onBlur={() => issue === null && setTyped(null)}
          onKeyDown={(event) => {
            const direction = { ArrowUp: 1, ArrowDown: -1 }[event.key];
            if (direction === undefined || value === null) return;
            event.preventDefault();
            const next = Math.min(max ?? Infinity, Math.max(min ?? -Infinity, value + direction * step));
            setTyped(null);
            onChange(next);
          }}
        />
        {unit && <span class="small">{unit}</span>}
      </span>
      <p id={`${id}-problem`} class="is-bad field-problem" data-testid={`${id}-problem`}>
        {shown}
      </p>
      {advice && <p class="is-warning field-problem">{advice}</p>}
      {children}
    </div>
  );
}

type Scaled = Pick<Props, "unit" | "value" | "min" | "max" | "step" | "onChange">;

/** Value and limits in the unit that is shown; what is typed goes back as metric, to a millionth. */
function inShownUnit({ unit: metric = "", value, min, max, step = 1, onChange }: Scaled) {
  const { unit, factor } = shownUnit(metric);
  const scaled = (limit: number | undefined): number | undefined =>
    limit === undefined ? undefined : Number((limit * factor).toPrecision(6));
  return {
    unit,
    value: value === null ? null : value * factor,
    min: scaled(min),
    max: scaled(max),
    step,
    onChange: (typed: number | null): void =>
      onChange(typed === null ? null : factor === 1 ? typed : Number((typed / factor).toFixed(6))),
  };
}

/** Problem of the typed text, or null. */
function typedIssue(text: string, isOptional: boolean, min = -Infinity, max = Infinity): string | null {
  if (text === "") return isOptional ? null : texts.fields.notNumber;
  const value = Number(text);
  if (!Number.isFinite(value)) return texts.fields.notNumber;
  return value < min || value > max ? texts.fields.range(min, max) : null;
}
