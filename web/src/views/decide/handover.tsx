/** Buttons for the hand-over on paper and the flight log. */
import { useState } from "preact/hooks";
import { FLIGHTS_URL, readHandover } from "../../api/handover";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";

export function HandoverButtons() {
  const { state, notation, isSurvey } = useShell();
  const [isMaking, setMaking] = useState(false);
  const [problem, setProblem] = useState("");
  if (!state.capabilities.handover) return null;
  const make = async (): Promise<void> => {
    setMaking(true);
    const answer = await readHandover(notation);
    setMaking(false);
    setProblem(answer.ok ? "" : answer.message);
    if (answer.ok) save(answer.value, `handover-${state.mission?.mission_id ?? "mission"}.pdf`);
  };
  return (
    <>
      <div class="button-row finding-files">
        <button type="button" data-testid="handover" disabled={isMaking} onClick={() => void make()}>
          {isMaking ? texts.handover.making : texts.handover.pdf}
        </button>
        {!isSurvey && (
          <a class="button" href={FLIGHTS_URL} download data-testid="flights">
            {texts.handover.flights}
          </a>
        )}
      </div>
      <p class="is-bad" role="alert" data-testid="handover-problem">
        {problem}
      </p>
    </>
  );
}

function save(file: Blob, name: string): void {
  const url = URL.createObjectURL(file);
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  URL.revokeObjectURL(url);
}
