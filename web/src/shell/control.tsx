/** Who of several operators has control: shown in the header, with a window for asking, giving and taking it over. */
import { useState } from "preact/hooks";
import type { Answer } from "../api/client";
import { answerRequest, askForControl, releaseControl, takeControl } from "../api/control";
import type { Control } from "../api/types";
import { type ControlView, controlView } from "../state/control";
import { texts } from "../texts";
import { Dialog } from "../ui/dialog";

/** Button that names who has control; nothing where an operator is alone. */
export function ControlButton({ control, own }: { control: Control | null; own: string }) {
  const [isOpen, setOpen] = useState(false);
  const view = controlView(control, own);
  if (view === null) return null;
  return (
    <>
      <button
        type="button"
        class={`control-button ${view.isMine ? "is-mine" : ""} ${view.asking === null ? "" : "is-asked"}`}
        data-testid="control"
        aria-live="polite"
        title={summary(view)}
        onClick={() => setOpen(true)}
      >
        {summary(view)}
      </button>
      {isOpen && <ControlDialog view={view} onClose={() => setOpen(false)} />}
    </>
  );
}

function summary({ asking, isMine, other, isFree }: ControlView): string {
  const { control } = texts.team;
  if (asking !== null) return control.asks(asking);
  if (isMine) return control.mine;
  if (other === null) return control.free;
  return isFree ? control.gone(other) : control.others(other);
}

function ControlDialog({ view, onClose }: { view: ControlView; onClose(): void }) {
  const [reason, setReason] = useState("");
  const [refusal, setRefusal] = useState<string | null>(null);
  const { control } = texts.team;
  const send = async (answer: Promise<Answer<Control>>, closes: boolean): Promise<void> => {
    const found = await answer;
    setRefusal(found.ok ? null : found.message);
    if (found.ok && closes) onClose();
  };
  const { asking } = view;
  const mustExplain = view.other !== null && !view.isFree;
  return (
    <Dialog title={control.title} testId="control-dialog" onClose={onClose}>
      <p>
        <strong>{summary(view)}</strong>
      </p>
      <p>{control.hint}</p>
      {view.isMine ? (
        <div class="dialog-buttons">
          {asking !== null && (
            <>
              <button
                type="button"
                data-testid="control-refuse"
                onClick={() => void send(answerRequest(asking, false), true)}
              >
                {control.refuse}
              </button>
              <button
                type="button"
                class="primary"
                data-testid="control-give"
                onClick={() => void send(answerRequest(asking, true), true)}
              >
                {control.give(asking)}
              </button>
            </>
          )}
          <button type="button" data-testid="control-release" onClick={() => void send(releaseControl(), true)}>
            {control.release}
          </button>
        </div>
      ) : (
        <form
          class="form"
          onSubmit={(event) => {
            event.preventDefault();
            void send(takeControl(reason), true);
          }}
        >
          {mustExplain && (
            <>
              <p>
                <button
                  type="button"
                  data-testid="control-ask"
                  disabled={view.haveAsked}
                  onClick={() => void send(askForControl(), false)}
                >
                  {control.ask}
                </button>{" "}
                {view.haveAsked && control.asked}
              </p>
              <label>
                {control.reason}
                <input
                  data-testid="control-reason"
                  required
                  minLength={3}
                  maxLength={200}
                  value={reason}
                  onInput={(event) => setReason(event.currentTarget.value)}
                />
              </label>
            </>
          )}
          <div class="dialog-buttons">
            <button type="submit" data-testid="control-take">
              {mustExplain ? control.takeOver : control.take}
            </button>
          </div>
        </form>
      )}
      <p class="is-bad" role="alert" data-testid="control-refusal">
        {refusal}
      </p>
    </Dialog>
  );
}
