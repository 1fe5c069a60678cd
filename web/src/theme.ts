/** Themes dark, light, and black on white for sunlight: the operator's choice, otherwise that of the system. */
import { useEffect, useState } from "preact/hooks";
import { readStored, store } from "./storage";

export const THEMES = ["dark", "light", "contrast"] as const;
export type Theme = (typeof THEMES)[number];

const KEY = "aos-gcs-theme";

function initialTheme(): Theme {
  const chosen = THEMES.find((theme) => theme === readStored(KEY));
  if (chosen !== undefined) return chosen;
  if (matchMedia("(prefers-contrast: more)").matches) return "contrast";
  return matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark";
}

/** Current theme and a function that changes and stores it. */
export function useTheme(): [Theme, (theme: Theme) => void] {
  const [theme, setTheme] = useState(initialTheme);
  document.documentElement.dataset["theme"] = theme;
  useEffect(() => {
    const query = matchMedia("(prefers-color-scheme: light)");
    const follow = (): void => setTheme(initialTheme());
    query.addEventListener("change", follow);
    return () => query.removeEventListener("change", follow);
  }, []);
  const choose = (chosen: Theme): void => {
    store(KEY, chosen);
    setTheme(chosen);
  };
  return [theme, choose];
}
