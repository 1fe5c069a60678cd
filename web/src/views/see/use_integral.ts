/** The integral of a step on a plane, asked for anew whenever the plane changes. */
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { Newest } from "../../api/newest";
import { type IntegralQuery, readIntegral } from "../../api/viewer";
import type { Bounds } from "../../geometry";

/** A picture that is ready to be shown. */
export interface ShownIntegral extends IntegralQuery {
  readonly url: string;
  readonly bounds: Bounds;
  readonly height_m: number;
  readonly visibility_m2: number;
  /** From the request until the picture, or its draft before, was decoded. */
  readonly latency_ms: number;
}

interface Result {
  readonly shown: ShownIntegral | null;
  readonly problem: string;
}

const NOTHING: Result = { shown: null, problem: "" };

/** The newest picture there is, and why there is no newer one; nothing without a query. */
export function useIntegral(query: IntegralQuery | null): Result {
  const [result, setResult] = useState(NOTHING);
  const isMounted = useRef(true);
  const newest = useMemo(
    () =>
      new Newest<IntegralQuery>(async (asked) => {
        const next = await load(asked);
        if (!isMounted.current) {
          if (next.shown) URL.revokeObjectURL(next.shown.url);
          return;
        }
        // A picture that is too old is better than none: its height stands beside it.
        setResult((before) => (next.shown === null ? { ...before, problem: next.problem } : following(before, next)));
      }),
    [],
  );
  // Before the page is painted, not after: the picture is one frame earlier there.
  useLayoutEffect(() => {
    if (query !== null) newest.ask(query);
  }, [query?.step, query?.kind, query?.height_m, query?.isDraft]);
  useEffect(() => {
    const url = result.shown?.url;
    return url === undefined ? undefined : () => URL.revokeObjectURL(url);
  }, [result.shown?.url]);
  useEffect(
    () => () => {
      isMounted.current = false;
      newest.forget();
    },
    [],
  );
  return query === null ? NOTHING : result;
}

/** An exact picture that takes the place of its draft is no news: what the operator has waited for was the draft. */
function following({ shown: before }: Result, next: Result): Result {
  if (before === null || next.shown === null || !before.isDraft) return next;
  const { step, kind, height_m } = next.shown;
  const isSame = before.step === step && before.kind === kind && before.height_m === height_m;
  return isSame ? { ...next, shown: { ...next.shown, latency_ms: before.latency_ms } } : next;
}

async function load(query: IntegralQuery): Promise<Result> {
  const askedAtMs = performance.now();
  const answer = await readIntegral(query);
  if (!answer.ok) return { shown: null, problem: answer.message };
  const { picture, ...facts } = answer.value;
  const url = URL.createObjectURL(picture);
  const image = new Image();
  image.src = url;
  // What cannot be decoded is shown by the browser as it shows broken pictures.
  await image.decode().catch(() => undefined);
  return { shown: { ...query, ...facts, url, latency_ms: performance.now() - askedAtMs }, problem: "" };
}
