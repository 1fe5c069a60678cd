/** Keys of the page. Pure functions: they interpret keystrokes, which the shell carries out. */
import type { ViewName } from "./route";

export interface Stroke {
  readonly key: string;
  /** Physical key, independent of layout and modifiers. */
  readonly code: string;
  readonly shiftKey: boolean;
  readonly altKey: boolean;
  readonly ctrlKey: boolean;
  readonly metaKey: boolean;
  readonly repeat: boolean;
}

/** Receiver of keystrokes: the page itself, a text field, or an open window. */
export type Focus = "page" | "text" | "dialog";

export type KeyCommand =
  | { readonly kind: "holdAll" }
  | { readonly kind: "view"; readonly view: ViewName }
  | { readonly kind: "digit"; readonly digit: string; readonly adds: boolean }
  | { readonly kind: "selectAll" | "clearSelection" | "showFinding" | "help" };

const HOLD_KEY = "h";
export const VIEW_KEYS: Readonly<Record<ViewName, string>> = {
  plan: "p",
  prepare: "r",
  fly: "f",
  see: "s",
  wall: "w",
  understand: "u",
  decide: "d",
};

/** Meaning of a keystroke, or null. Hold works everywhere, in text fields with Alt. */
export function keyCommand(stroke: Stroke, focus: Focus): KeyCommand | null {
  if (stroke.repeat || stroke.ctrlKey || stroke.metaKey) return null;
  const letter = /^Key[A-Z]$/.test(stroke.code) && stroke.altKey ? stroke.code.slice(3) : stroke.key;
  const key = letter.toLowerCase();
  if (key === HOLD_KEY && (focus !== "text" || stroke.altKey)) return { kind: "holdAll" };
  if (focus !== "page" || stroke.altKey) return null;
  const digit = /^(?:Digit|Numpad)(\d)$/.exec(stroke.code)?.[1];
  if (digit !== undefined) return { kind: "digit", digit, adds: stroke.shiftKey };
  if (key === "a") return { kind: "selectAll" };
  if (key === "n") return { kind: "showFinding" };
  if (key === "escape") return { kind: "clearSelection" };
  if (key === "?") return { kind: "help" };
  const view = (Object.keys(VIEW_KEYS) as ViewName[]).find((name) => VIEW_KEYS[name] === key);
  return view === undefined ? null : { kind: "view", view };
}

/** Whether a key that is held presses a button once more, such as one that has got the focus meanwhile. */
export function pressesAgain({ key, repeat, target }: Pick<KeyboardEvent, "key" | "repeat" | "target">): boolean {
  return repeat && (key === "Enter" || key === " ") && target instanceof HTMLButtonElement;
}

const NOT_TYPED_INTO = new Set(["button", "checkbox", "radio", "range", "submit", "reset", "file", "color"]);

/** Current receiver of keystrokes. */
export function focusOf(target: EventTarget | null, page: Document): Focus {
  if (target instanceof HTMLInputElement && !NOT_TYPED_INTO.has(target.type)) return "text";
  if (target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement) return "text";
  if (target instanceof HTMLElement && target.isContentEditable) return "text";
  return page.querySelector("dialog[open]") === null ? "page" : "dialog";
}
