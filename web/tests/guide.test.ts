/** The operator's guide prints labels of the page in italics: each must be a text of the page, or the beginning of one. */
import { expect, test } from "vitest";
import guide from "../../docs/operator-guide.md?raw";
import { texts } from "../src/texts";

/** All strings below a value; functions by their source, which has the fixed parts of their templates. */
function stringsOf(value: unknown): string[] {
  if (typeof value === "string") return [value];
  if (typeof value === "function") return [String(value)];
  return typeof value === "object" && value !== null ? Object.values(value).flatMap(stringsOf) : [];
}

const TEXTS = stringsOf(texts);
const LABELS = [...guide.matchAll(/(?<!\*)\*(?!\*)([^*]+)\*(?!\*)/g)].map(
  ([, label]) => label?.replace(/\s+/g, " ") ?? "",
);

/** Whether a text has the label as whole words; "…" in the label stands for what the page fills in. */
function isLabelOf(label: string, text: string): boolean {
  const escaped = label.split("…").map((part) => part.trim().replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`(?<!\\w|\\w )${escaped.join(".+")}(?!\\w)`).test(text);
}

test("labels are found in the guide", () => {
  expect(LABELS.length).toBeGreaterThan(50);
});

test.each([...new Set(LABELS)])("%s is a text of the page", (label) => {
  expect(TEXTS.some((text) => isLabelOf(label, text))).toBe(true);
});
