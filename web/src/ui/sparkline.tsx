/** Small curve of one value over time, for a first look; not known values are gaps. */

interface Props {
  label: string;
  /** The latest value in words. */
  words: string;
  values: readonly (number | null)[];
  /** Least extent of the vertical axis, so that noise does not look like change. */
  span: number;
}

const POINTS = 120;
const [WIDTH, HEIGHT] = [100, 30];

export function Sparkline({ label, words, values, span }: Props) {
  return (
    <figure class="sparkline">
      <figcaption>
        {label} <b>{words}</b>
      </figcaption>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" aria-hidden="true">
        <path d={sparkPath(values, span)} />
      </svg>
    </figure>
  );
}

/** Path of the values in a box of 100 by 30, at most so many points that each can be seen. */
export function sparkPath(values: readonly (number | null)[], span: number): string {
  const every = Math.max(1, Math.ceil(values.length / POINTS));
  // From the latest one backwards: it is always drawn.
  const drawn = values.filter((_, index) => (values.length - 1 - index) % every === 0);
  const known = drawn.filter((value) => value !== null);
  if (known.length === 0) return "";
  const [low, high] = [Math.min(...known), Math.max(...known)];
  const middle = (low + high) / 2;
  const extent = Math.max(span, high - low);
  const at = (value: number): number => HEIGHT / 2 - ((value - middle) / extent) * (HEIGHT - 4);
  const step = WIDTH / Math.max(1, drawn.length - 1);
  let path = "";
  drawn.forEach((value, index) => {
    if (value === null) return;
    const before = drawn[index - 1] ?? null;
    path += `${before === null ? "M" : "L"}${(index * step).toFixed(1)} ${at(value).toFixed(1)}`;
  });
  return path;
}
