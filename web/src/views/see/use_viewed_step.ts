/** What can be seen of a step. */
import { useEffect, useState } from "preact/hooks";
import type { Answer } from "../../api/client";
import type { ViewedStep } from "../../api/types";
import { describeStep } from "../../api/viewer";

/** That of the step before while the answer is on its way; null before the first one. */
export function useViewedStep(step: number | null): Answer<ViewedStep> | null {
  const [answer, setAnswer] = useState<Answer<ViewedStep> | null>(null);
  useEffect(() => {
    if (step === null) return undefined;
    let isWanted = true;
    void describeStep(step).then((told) => isWanted && setAnswer(told));
    return () => {
      isWanted = false;
    };
  }, [step]);
  return step === null ? null : answer;
}
