/** Window with a finding in words, to be copied or handed to another program of this device. */
import { useState } from "preact/hooks";
import type { Finding } from "../../api/types";
import { useShell } from "../../shell/context";
import { texts } from "../../texts";
import { Dialog } from "../../ui/dialog";
import { useCopy } from "./copy";
import { messageAbout } from "./message";
import type { Reference } from "./way";

interface Props {
  finding: Finding;
  reference: Reference;
  onClose(): void;
}

export function SendOn({ finding, reference, onClose }: Props) {
  const { state, notation } = useShell();
  const { copied, canCopy, copy } = useCopy();
  const [isRefused, setRefused] = useState(false);
  if (state.mission === null) return null;
  const text = messageAbout(finding, state.mission, notation, reference);
  const title = texts.decide.finding(finding.finding_id);
  const share = async (): Promise<void> => {
    try {
      await navigator.share({ title, text });
    } catch (error) {
      // Closing the system's window is no failure.
      setRefused(!(error instanceof DOMException && error.name === "AbortError"));
    }
  };
  return (
    <Dialog title={texts.decide.sendOn} testId="send-on-window" onClose={onClose}>
      <textarea
        class="message-text"
        rows={9}
        readOnly
        aria-label={title}
        data-testid="message-text"
        value={text}
        onFocus={(event) => event.currentTarget.select()}
      />
      <p class="small">{canCopy ? texts.decide.sendHint : texts.decide.copyByHand}</p>
      {isRefused && (
        <p class="is-bad" role="alert">
          {texts.decide.notShared}
        </p>
      )}
      <div class="dialog-buttons">
        {canCopy && (
          <button type="button" class="primary" data-testid="message-copy" onClick={() => void copy(text)}>
            {copied === text ? texts.decide.copied : texts.decide.copy}
          </button>
        )}
        {"share" in navigator && (
          <button type="button" data-testid="message-share" onClick={() => void share()}>
            {texts.decide.share}
          </button>
        )}
        <a
          class="button"
          data-testid="message-mail"
          href={`mailto:?subject=${encodeURIComponent(title)}&body=${encodeURIComponent(text)}`}
        >
          {texts.decide.mail}
        </a>
      </div>
    </Dialog>
  );
}
