/** Hook for the recorded images and frames of a step. */
import { useEffect, useState } from "preact/hooks";
import type { Answer } from "../../api/client";
import type { ViewedStep } from "../../api/types";
import { describeStep } from "../../api/viewer";

/** A step can be announced before its frames are on the disk. */
const TRIES = 10;
const TRY_AGAIN_AFTER_MS = 1500;

/** Description of the step, that of the previous one while the answer is pending; null before the first answer. */
export function useViewedStep(step: number | null): Answer<ViewedStep> | null {
  const [answer, setAnswer] = useState<Answer<ViewedStep> | null>(null);
  useEffect(() => {
    if (step === null) return undefined;
    let isWanted = true;
    let timer: ReturnType<typeof setTimeout>;
    const ask = async (tries: number): Promise<void> => {
      const described = await describeStep(step);
      if (!isWanted) return;
      setAnswer(described);
      if (!described.ok && tries > 1) timer = setTimeout(() => void ask(tries - 1), TRY_AGAIN_AFTER_MS);
    };
    void ask(TRIES);
    return () => {
      isWanted = false;
      clearTimeout(timer);
    };
  }, [step]);
  return step === null ? null : answer;
}
