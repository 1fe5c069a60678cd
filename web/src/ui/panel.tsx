/** Framed part of a view with its heading. */
import type { ComponentChildren } from "preact";

interface Props {
  title: string;
  testId: string;
  /** Content beside the heading. */
  aside?: ComponentChildren;
  class?: string;
  children: ComponentChildren;
}

export function Panel({ title, testId, aside, class: extra = "", children }: Props) {
  return (
    <section class={`panel ${extra}`} aria-label={title} data-testid={testId}>
      <div class="panel-head">
        <h2>{title}</h2>
        {aside}
      </div>
      {children}
    </section>
  );
}
