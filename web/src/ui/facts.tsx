/** List of facts by name; those with an empty value are left out. */

export type Fact = readonly [name: string, value: string];

export function Facts({ facts, class: extra }: { facts: readonly Fact[]; class?: string }) {
  return (
    <dl class={extra}>
      {facts
        .filter(([, value]) => value !== "")
        .map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
    </dl>
  );
}
