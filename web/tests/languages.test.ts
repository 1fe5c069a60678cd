/** Catalogues of the languages: complete, alike in what they fill in, and the only place where texts stand. */
import { afterEach, describe, expect, test } from "vitest";
import { chooseLanguage, chosenLanguage, LANGUAGES, said, type Texts, texts } from "../src/texts";
import { english } from "../src/texts/english";
import { german } from "../src/texts/german";
import { type StationText, translator } from "../src/texts/station";

afterEach(() => chooseLanguage("en"));

/** Texts that are the same in both languages: names, units, symbols. */
const ALIKE =
  /^(?:[^a-z]*|[A-Za-z]{1,4}|.*\b(?:GPS|KML|UTM|GeoJSON|GeoTIFF|RTK|DGPS|aos-gcs)\b.*|[^a-z]*[a-z]²?[^a-z]*)$/;
const ALSO_GERMAN = new Set(
  ["Plan", "Position", "Information", "Filter", "Pause", "Info", "Link", "Name", "Autofocus", "Phase", "Layer"].concat(
    ["Mission", "Manual", "Integral", "Normal", "Version", "Escape", "5 min", "1 min", "5", "Visible area, m²"],
    ["Geofence", "2D", "3D", "Firmware", "static", "N", "Imperial", "Start", "System"],
  ),
);

/** A sentinel that no text contains; as a number it can be counted and compared. */
const NUMBER = 4711;

/** Leaves of a tree of texts by their paths; a function is called with values that can be found in its result. */
function leavesOf(value: unknown, path = ""): Map<string, string> {
  if (typeof value === "string") return new Map([[path, value]]);
  if (typeof value === "function") return new Map([[path, called(value as (...values: unknown[]) => string)]]);
  const leaves = new Map<string, string>();
  for (const [key, child] of Object.entries(value as Record<string, unknown>)) {
    for (const [at, text] of leavesOf(child, `${path}.${key}`)) leaves.set(at, text);
  }
  return leaves;
}

function called(text: (...values: unknown[]) => string): string {
  for (const kinds of [
    ["text", "text", "text"],
    ["number", "number", "number"],
    ["texts", "number", "text"],
    ["action", "action", "action"],
    ["picture", "number", "number"],
    ["picture", "text", "text"],
  ]) {
    const result = tried(() => text(...kinds.slice(0, Math.max(1, text.length)).map(sample)));
    if (result !== null && !result.includes("undefined")) return result;
  }
  throw new Error(`no values for ${String(text)}`);
}

function sample(kind: string, index: number): unknown {
  if (kind === "number") return NUMBER + index;
  if (kind === "texts") return [`<${index}>`];
  if (kind === "action") return "start";
  if (kind === "picture") return "thermal";
  return `<${index}>`;
}

function tried(action: () => string): string | null {
  try {
    return action();
  } catch {
    return null;
  }
}

/** What a function has filled in. */
const filledIn = (text: string): string[] => (text.match(/<\d>|471\d/g) ?? []).sort();

const ENGLISH = leavesOf(english);

describe.each([["german", german.texts]] satisfies [string, Texts][])("%s", (_, translated) => {
  const leaves = leavesOf(translated);

  test("has the same texts", () => {
    expect([...leaves.keys()]).toEqual([...ENGLISH.keys()]);
    expect([...leaves].filter(([path, text]) => text === "" && ENGLISH.get(path) !== "")).toEqual([]);
  });

  test("fills in the same values", () => {
    const different = [...leaves].filter(
      ([path, text]) => filledIn(text).join() !== filledIn(ENGLISH.get(path) ?? "").join(),
    );
    expect(different).toEqual([]);
  });

  test("is translated", () => {
    const same = [...leaves].filter(
      ([path, text]) => text === ENGLISH.get(path) && !ALIKE.test(text) && !ALSO_GERMAN.has(text),
    );
    expect(same).toEqual([]);
  });
});

test("a language is chosen for all texts, and what is not known stays in English", async () => {
  expect(LANGUAGES).toContain("de");
  await chooseLanguage("de");
  expect(chosenLanguage()).toBe("de");
  expect(texts.header.holdAll).toBe("ALLE HALTEN");
  expect(said("link restored")).toBe("Funk wieder da");
  expect(said("EKF3 IMU1 is using GPS")).toBe("EKF3 IMU1 is using GPS");
  await chooseLanguage("en");
  expect(texts.header.holdAll).toBe("HOLD ALL");
  expect(said("link restored")).toBe("link restored");
});

describe("texts of the station", () => {
  const CATALOGUE: readonly StationText[] = [
    ["link lost for {age} s: {reason}", "Funk seit {age} s verloren: {reason}"],
    ["link lost for {age} s", "Funk seit {age} s verloren"],
    ["the radio is off", "das Funkgerät ist aus"],
    ["battery at {battery}", "Akku bei {battery}"],
    ["battery low{where}", "Akku schwach{where}"],
    ["Leg {leg} of {legs}", "Von {legs} Bahnen die {leg}."],
  ];
  const translated = translator(CATALOGUE);

  test.each([
    ["link lost for 12 s", "Funk seit 12 s verloren"],
    ["link lost for 12 s: the radio is off", "Funk seit 12 s verloren: das Funkgerät ist aus"],
    ["link lost for 12 s: (odd) [reason]", "Funk seit 12 s verloren: (odd) [reason]"],
    ["battery low", "Akku schwach"],
    ["Leg 2 of 7", "Von 7 Bahnen die 2."],
    ["battery at 21 %. the radio is off", "Akku bei 21 %. das Funkgerät ist aus"],
    ["battery at 21 %. something new", "Akku bei 21 %. something new"],
    ["the radio is off. something new", "the radio is off. something new"],
    ["unknown", "unknown"],
    ["", ""],
  ])("%s", (english, german) => {
    expect(translated(english)).toBe(german);
    expect(translated(english)).toBe(german); // remembered
  });

  test("a catalogue has each text once, with the same names in both languages", () => {
    const names = (text: string): string => (text.match(/\{\w+\}/g) ?? []).sort().join();
    expect(german.station.filter(([from, to]) => names(from) !== names(to))).toEqual([]);
    const texts = german.station.map(([from]) => from.replaceAll(/\{\w+\}/g, "{}"));
    expect(texts.filter((text, index) => texts.indexOf(text) !== index)).toEqual([]);
  });

  test("a text that is filled in says enough to be recognized", () => {
    const fixed = (text: string): string => text.replaceAll(/\{\w+\}/g, "").replaceAll(/[^A-Za-z]/g, "");
    // What only ever follows another text begins with its punctuation.
    const filled = german.station.filter(([from]) => from.includes("{"));
    expect(filled.filter(([from]) => fixed(from).length < 4 && !/^[,:.±]/.test(from))).toEqual([]);
  });

  test.each(german.station.filter(([from]) => from.includes("{")))("%s is found", (from, to) => {
    const filled = (text: string): string => text.replaceAll(/\{\w+\}/g, (name) => `‹${name.slice(1, -1)}›`);
    expect(translator(german.station)(filled(from))).toBe(filled(to));
  });
});

const SOURCES = import.meta.glob("../src/**/*.{ts,tsx}", { query: "?raw", import: "default", eager: true }) as Record<
  string,
  string
>;
const COMPONENTS = Object.entries(SOURCES).filter(([path]) => !path.includes("/texts"));

test("components hold no literal texts", () => {
  const literals = [
    /(?:title|aria-label|alt|placeholder|label)="[^"]*[a-z]{2}/, // of an attribute
    />\s*[A-Z][a-z]+[^<>={}()]*<\//, // between tags
  ];
  const found = COMPONENTS.flatMap(([path, source]) =>
    path.endsWith(".tsx")
      ? literals.flatMap((literal) => (literal.exec(source) ?? []).map((at) => `${path}: ${at}`))
      : [],
  );
  expect(COMPONENTS.length).toBeGreaterThan(100);
  expect(found).toEqual([]);
});

test("no module keeps a text from before the language changes", () => {
  const found = COMPONENTS.flatMap(([path, source]) =>
    source
      .split(/\n(?=\S)/)
      .filter((block) => /^(?:export )?const \w+[^(]*= (?!.*=>)[^\n]*\btexts\./.test(block))
      .map((block) => `${path}: ${block.slice(0, 80)}`),
  );
  expect(found).toEqual([]);
});
