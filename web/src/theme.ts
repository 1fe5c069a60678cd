/** Dark or light: the operator's choice, else the system's. */
import { useEffect, useState } from "preact/hooks";
import type { Theme } from "./map/palette";

const KEY = "aos-gcs-theme";

function initialTheme(): Theme {
  const chosen = localStorage.getItem(KEY);
  if (chosen === "dark" || chosen === "light") return chosen;
  return matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark";
}

/** The theme in force and a function that changes and keeps it. */
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
    localStorage.setItem(KEY, chosen);
    setTheme(chosen);
  };
  return [theme, choose];
}
