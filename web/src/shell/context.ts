/** State and functions that the shell provides to every view by {@link useShell}. */
import { createContext } from "preact";
import { useContext } from "preact/hooks";
import type { Notation } from "../coordinates";
import type { Alert } from "../state/alerts";
import type { Selection } from "../state/selection";
import type { State } from "../state/state";
import type { Theme } from "../theme";
import type { Commands } from "./commands";
import type { Route, ViewName } from "./route";
import type { AskedName } from "./use_asked_name";

export interface Shell {
  readonly state: State;
  /** Seconds since the last update of the mission, to be added to every age in its state. */
  readonly snapshotAge_s: number;
  readonly isConnected: boolean;
  readonly isOperator: boolean;
  /** Whether this page may command: no observer, no recording, no survey. Otherwise views hide all commands. */
  readonly mayCommand: boolean;
  /** Name that actions of this page are recorded with; empty while nobody has signed in. */
  readonly operator: string;
  /** Name that the page asks for before it may command; null where it asks for none. */
  readonly asked: AskedName | null;
  /** Alerts that nobody has acknowledged, the most severe first. */
  readonly alerts: readonly Alert[];
  /** Whether this page may mark and judge findings. */
  readonly mayJudge: boolean;
  /** Whether this page may have videos of the wall made, also of a recording. */
  readonly mayMakeVideos: boolean;
  /** Whether a recorded flight is shown, without vehicles. */
  readonly isSurvey: boolean;
  readonly theme: Theme;
  /** How positions on the globe are written. */
  readonly notation: Notation;
  readonly route: Route;
  navigate(view: ViewName, params?: Route["params"]): void;
  readonly selection: Selection;
  changeSelection(change: (before: Selection) => Selection): void;
  readonly commands: Commands;
}

export const ShellContext = createContext<Shell | null>(null);

export function useShell(): Shell {
  const shell = useContext(ShellContext);
  if (shell === null) throw new Error("useShell() outside of the shell");
  return shell;
}
