/** Confirmation of a dangerous command: its scope, its consequence, and a button that has to be held. */
import { Dialog } from "../ui/dialog";
import { HoldButton } from "../ui/hold_button";
import { texts } from "../texts";
import type { Commands } from "./commands";

export function Question({ commands }: { commands: Commands }) {
  const { question } = commands;
  if (question === null) return null;
  return (
    <Dialog title={`${question.label}?`} testId="confirm" onClose={commands.cancel}>
      <p>{texts.actions.consequence[question.action]}</p>
      <div class="dialog-buttons">
        <button type="button" data-testid="confirm-cancel" onClick={commands.cancel}>
          {texts.actions.cancel}
        </button>
        <HoldButton label={texts.actions.holdTo(question.action)} testId="confirm-ok" onConfirm={commands.confirm} />
      </div>
    </Dialog>
  );
}
