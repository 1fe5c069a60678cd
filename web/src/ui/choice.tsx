/** Row of buttons of which one is selected. */
export interface ChoiceProps<T extends string> {
  label: string;
  testId: string;
  values: readonly T[];
  chosen: T | null;
  labels: Readonly<Record<T, string>>;
  onChoose(value: NoInfer<T>): void;
}

export function Choice<T extends string>({ label, testId, values, chosen, labels, onChoose }: ChoiceProps<T>) {
  return (
    <div class="choice" role="group" aria-label={label}>
      {values.map((value) => (
        <button
          key={value}
          type="button"
          data-testid={`${testId}-${value}`}
          aria-pressed={value === chosen}
          onClick={() => onChoose(value)}
        >
          {labels[value]}
        </button>
      ))}
    </div>
  );
}
