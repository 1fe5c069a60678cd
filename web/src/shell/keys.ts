/** The page's keys. Pure: what a stroke means; the shell carries it out. */
import type { ViewName } from "./route";

export interface Stroke {
  readonly key: string;
  /** The physical key, independent of layout and modifiers. */
  readonly code: string;
  readonly shiftKey: boolean;
  readonly altKey: boolean;
  readonly ctrlKey: boolean;
  readonly metaKey: boolean;
  readonly repeat: boolean;
}

/** What has the keyboard: nothing in particular, a field for text, or an open question. */
export type Focus = "page" | "text" | "dialog";

export type KeyCommand =
  | { readonly kind: "holdAll" }
  | { readonly kind: "view"; readonly view: ViewName }
  | { readonly kind: "digit"; readonly digit: string; readonly adds: boolean }
  | { readonly kind: "selectAll" | "clearSelection" | "help" };

export const HOLD_KEY = "h";
export const VIEW_KEYS: Readonly<Record<ViewName, string>> = {
  plan: "p",
  prepare: "r",
  fly: "f",
  see: "s",
  understand: "u",
  decide: "d",
};

/** The meaning of a stroke, or null. Holding works everywhere: in text fields and questions with Alt. */
export function keyCommand(stroke: Stroke, focus: Focus): KeyCommand | null {
  if (stroke.repeat || stroke.ctrlKey || stroke.metaKey) return null;
  const letter = /^Key[A-Z]$/.test(stroke.code) && stroke.altKey ? stroke.code.slice(3) : stroke.key;
  const key = letter.toLowerCase();
  if (key === HOLD_KEY && (focus !== "text" || stroke.altKey)) return { kind: "holdAll" };
  if (focus !== "page" || stroke.altKey) return null;
  const digit = /^(?:Digit|Numpad)(\d)$/.exec(stroke.code)?.[1];
  if (digit !== undefined) return { kind: "digit", digit, adds: stroke.shiftKey };
  if (key === "a") return { kind: "selectAll" };
  if (key === "escape") return { kind: "clearSelection" };
  if (key === "?") return { kind: "help" };
  const view = (Object.keys(VIEW_KEYS) as ViewName[]).find((name) => VIEW_KEYS[name] === key);
  return view === undefined ? null : { kind: "view", view };
}

const NOT_TYPED_INTO = new Set(["button", "checkbox", "radio", "range", "submit", "reset", "file", "color"]);

/** What has the keyboard now. */
export function focusOf(target: EventTarget | null, page: Document): Focus {
  if (target instanceof HTMLInputElement && !NOT_TYPED_INTO.has(target.type)) return "text";
  if (target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement) return "text";
  if (target instanceof HTMLElement && target.isContentEditable) return "text";
  return page.querySelector("dialog[open]") === null ? "page" : "dialog";
}
