/**
 * Modal window inside the page; Escape and a cross close it, and its first button has the focus. Afterwards the focus is
 * where it was, or else in the view, so that the next press of Tab does not begin at the top of the page.
 */
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
    const focused = document.activeElement;
    element?.showModal();
    return () => {
      // The browser tells of it later, when another window may be open.
      isGone.current = true;
      element?.close();
      giveFocusBack(focused);
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

/** Focus an element, or the view where it is gone or disabled by then; nothing where something else has the focus. */
function giveFocusBack(element: Element | null): void {
  const isLost = (): boolean => document.activeElement === null || document.activeElement === document.body;
  if (isLost() && element instanceof HTMLElement) element.focus({ preventScroll: true });
  if (isLost()) document.querySelector("main")?.focus({ preventScroll: true });
}
