/**
 * Texts of the page in the language that is chosen on this screen.
 *
 * `texts` is a live binding: read it while something is rendered or said, and keep none of its strings in a constant of a
 * module, since the language may change.
 */
import { readStored, store } from "./storage";
import type { english } from "./texts/english";
import { type StationText, translator } from "./texts/station";

/** The same tree with any strings: what a translation has to provide. */
type Translated<T> = T extends string
  ? string
  : T extends (...values: infer Values) => string
    ? (...values: Values) => string
    : { readonly [Key in keyof T]: Translated<T[Key]> };

export type Texts = Translated<typeof english>;

/** A language, as it is loaded; only the chosen one is. */
export interface Catalogue {
  readonly texts: Texts;
  /** Texts of the station in English, with names for what it fills in, and their translations. */
  readonly station: readonly StationText[];
}

export const LANGUAGES = ["en", "de"] as const;
export type Language = (typeof LANGUAGES)[number];

/** Name of each language in itself. */
export const LANGUAGE_NAMES: Readonly<Record<Language, string>> = { en: "English", de: "Deutsch" };

const LOADERS: Readonly<Record<Language, () => Promise<Catalogue>>> = {
  en: async () => ({ texts: (await import("./texts/english")).english, station: [] }),
  de: async () => (await import("./texts/german")).german,
};

const KEY = "aos-gcs-language";

/** None before the first {@link chooseLanguage}, for which the page waits. */
export let texts!: Texts;
let chosen: Language = "en";
let translate = translator([]);

export const chosenLanguage = (): Language => chosen;

/** Show a language from now on; what is on the screen already has to be rendered anew. Fails if it cannot be loaded. */
export async function chooseLanguage(language: Language): Promise<void> {
  const catalogue = await LOADERS[language]();
  texts = catalogue.texts;
  translate = translator(catalogue.station);
  chosen = language;
  if (typeof document !== "undefined") document.documentElement.lang = language;
}

/** Text of the station in the chosen language; one that its catalogue lacks stays in English. */
export const said = (text: string): string => translate(text);

/** Language that was chosen on this screen; before, the first one of the browser that the page has. */
export function storedLanguage(): Language {
  const wanted = [readStored(KEY), ...navigator.languages].map((tag) => tag?.split("-")[0]);
  return wanted.flatMap((tag) => LANGUAGES.filter((language) => language === tag))[0] ?? "en";
}

export const storeLanguage = (language: Language): void => store(KEY, language);
