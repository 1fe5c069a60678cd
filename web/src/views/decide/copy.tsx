/** Button that copies a text. */
import { useState } from "preact/hooks";
import { texts } from "../../texts";

interface Copying {
  /** Text that was copied last. */
  readonly copied: string | null;
  /** Browsers disable the clipboard on pages with a plain HTTP address of another machine. */
  readonly canCopy: boolean;
  copy(text: string): Promise<void>;
}

export function useCopy(): Copying {
  const [copied, setCopied] = useState<string | null>(null);
  const copy = async (text: string): Promise<void> => {
    try {
      await navigator.clipboard.writeText(text);
      setCopied(text);
    } catch {
      setCopied(null); // refused by the browser; the text can still be selected
    }
  };
  return { copied, canCopy: window.isSecureContext, copy };
}

export function Copy({ text, label }: { text: string; label: string }) {
  const { copied, canCopy, copy } = useCopy();
  if (!canCopy) return null;
  return (
    <button type="button" aria-label={label} onClick={() => void copy(text)}>
      {copied === text ? texts.decide.copied : texts.decide.copy}
    </button>
  );
}
