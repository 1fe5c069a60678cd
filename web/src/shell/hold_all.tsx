/** Button that holds all vehicles at any time. */
import { texts } from "../texts";

export function HoldAll({ testId, onHoldAll }: { testId: string; onHoldAll(): void }) {
  return (
    <button
      type="button"
      class="hold-all"
      data-testid={testId}
      aria-keyshortcuts="H"
      title={texts.header.holdAllHint}
      onClick={onHoldAll}
    >
      {texts.header.holdAll}
      <small>{texts.header.holdAllKey}</small>
    </button>
  );
}
