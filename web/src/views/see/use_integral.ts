/** Hook for the integral of a step on a plane, requested again whenever the plane changes. */
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import { Newest } from "../../api/newest";
import { type IntegralQuery, readIntegral } from "../../api/viewer";
import type { Bounds } from "../../geometry";

/** Integral image that is ready to be shown. */
export interface ShownIntegral extends IntegralQuery {
  readonly url: string;
  readonly bounds: Bounds;
  readonly height_m: number;
  readonly visibility_m2: number;
  /** Time from the request until the image, or the draft before it, was decoded. */
  readonly latency_ms: number;
}

interface Result {
  readonly shown: ShownIntegral | null;
  readonly problem: string;
}

const NOTHING: Result = { shown: null, problem: "" };

/** Latest image, and why there is no newer one; nothing without a query. */
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
        // An outdated image is better than none; its label names its height.
        setResult((before) => (next.shown === null ? { ...before, problem: next.problem } : following(before, next)));
      }),
    [],
  );
  // Before the page is painted, so that the request leaves one frame earlier.
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

/**
 * Result after the next one has arrived. An exact image keeps the response time of its draft, for which the operator
 * waited.
 */
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
  // An image that cannot be decoded is shown by the browser as a broken image.
  await image.decode().catch(() => undefined);
  return { shown: { ...query, ...facts, url, latency_ms: performance.now() - askedAtMs }, problem: "" };
}
