/**
 * Translation of what the station says: notices, checks, refusals.
 *
 * The station speaks English, in its log and in recorded missions as on the page. Its texts are sentences in which it has
 * filled in values; a catalogue names those values in braces, "link lost for {age}", and so finds and translates the
 * sentence whatever they are. A value that is a text of the station itself, such as a reason, is translated as well.
 */

/** English text of the station with names in braces for what it fills in, and its translation with the same names. */
export type StationText = readonly [english: string, translation: string];

interface Pattern {
  readonly expression: RegExp;
  readonly names: readonly string[];
  readonly translation: string;
  /** Number of letters that are fixed: of several patterns that fit, the one with the most says the most. */
  readonly fixed: number;
}

const PLACEHOLDER = /\{(\w+)\}/g;
/** Translations that are remembered: a page shows the same texts again and again. */
const REMEMBERED = 500;

/** Return a function that translates a text, or returns it as it is where the catalogue has no translation. */
export function translator(catalogue: readonly StationText[]): (text: string) => string {
  if (catalogue.length === 0) return (text) => text;
  const fixed = new Map(catalogue.filter(([english]) => !english.includes("{")));
  const patterns = catalogue
    .filter(([english]) => english.includes("{"))
    .map(patternOf)
    .sort((a, b) => b.fixed - a.fixed);
  const remembered = new Map<string, string | null>();

  const find = (text: string): string | null => {
    const exact = fixed.get(text);
    if (exact !== undefined) return exact;
    const sentences = joined(text);
    if (sentences !== null) return sentences;
    for (const { expression, names, translation } of patterns) {
      const values = expression.exec(text);
      if (values === null) continue;
      const byName = new Map(names.map((name, index) => [name, values[index + 1] ?? ""]));
      return translation.replaceAll(PLACEHOLDER, (_, name: string) => whole(byName.get(name) ?? ""));
    }
    return null;
  };

  /** Several sentences of which each is known; null if one is not: half a translation could be misread. */
  const joined = (text: string): string | null => {
    for (const separator of [". ", "; ", ", "]) {
      const parts = text.split(separator);
      if (parts.length < 2) continue;
      const last = parts.pop() ?? "";
      const ending = last.endsWith(".") ? "." : "";
      const all = [...parts, ending === "" ? last : last.slice(0, -1)].map((part) => remember(part));
      if (all.every((part) => part !== null)) return all.join(separator) + ending;
    }
    return null;
  };

  const remember = (text: string): string | null => {
    let translation = remembered.get(text);
    if (translation === undefined) {
      translation = find(text);
      if (remembered.size >= REMEMBERED) remembered.clear();
      remembered.set(text, translation);
    }
    return translation;
  };

  const whole = (text: string): string => remember(text) ?? text;
  return whole;
}

function patternOf([english, translation]: StationText): Pattern {
  const names = [...english.matchAll(PLACEHOLDER)].map(([, name]) => name ?? "");
  const parts = english.split(/\{\w+\}/);
  const source = parts.map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")).join("(.*?)");
  return { expression: new RegExp(`^${source}$`, "s"), names, translation, fixed: parts.join("").length };
}
