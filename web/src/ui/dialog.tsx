/** Modal window inside the page; Escape and a cross close it, and its first button has the focus. */
import { type ComponentChildren, createContext } from "preact";
import { useContext, useEffect, useRef } from "preact/hooks";
import { texts } from "../texts";

/** Content of the lower corner of every window, for what must not be covered. */
export const DialogCorner = createContext<ComponentChildren>(null);

interface Props {
  title: string;
  testId: string;
  onClose(): void;
  children: ComponentChildren;
}

export function Dialog({ title, testId, onClose, children }: Props) {
  const dialog = useRef<HTMLDialogElement>(null);
  const isGone = useRef(false);
  const corner = useContext(DialogCorner);
  useEffect(() => {
    const element = dialog.current;
    element?.showModal();
    return () => {
      // The browser tells of it later, when another window may be open.
      isGone.current = true;
      element?.close();
    };
  }, []);
  return (
    <dialog
      ref={dialog}
      class="dialog"
      data-testid={testId}
      aria-label={title}
      onClose={() => !isGone.current && onClose()}
    >
      <h2>{title}</h2>
      {children}
      {/* Both last, so that they do not get the first focus. */}
      <button
        type="button"
        class="dialog-close"
        aria-label={texts.dialog.close}
        onClick={() => dialog.current?.close()}
      >
        ✕
      </button>
      {corner && <div class="dialog-corner">{corner}</div>}
    </dialog>
  );
}
