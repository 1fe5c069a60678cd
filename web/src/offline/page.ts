/** The page's side of being opened without the station: the service worker, the last state, and the page's own age. */
import type { Store } from "../state/store";
import { databaseShelf } from "./database";
import { LastState } from "./last_state";

/** Whether this browser opens the page without the station. */
export type OfflinePage = "ready" | "insecure" | "unavailable";

const STATION_WITHIN_MS = 3000;
/** Script of this page, whose name changes with every build. */
const BUILD = new URL(import.meta.url).pathname;

export const lastState = new LastState(databaseShelf, BUILD);

let offlinePage: OfflinePage = "unavailable";
export const offlinePageState = (): OfflinePage => offlinePage;

/** Have the browser keep the page. Browsers do so for localhost and encrypted connections alone. */
export async function keepPage(): Promise<void> {
  if (!isSecureContext) {
    offlinePage = "insecure";
    return;
  }
  try {
    await navigator.serviceWorker.register("/service-worker.js");
    await navigator.serviceWorker.ready;
    offlinePage = "ready";
  } catch (error) {
    console.warn("The page cannot be opened without the station in this browser.", error);
  }
}

/** Show the last state if the station cannot be reached; one that answers decides itself who sees what. */
export async function showLastState(store: Store): Promise<void> {
  if (store.state.mission !== null || (await isStationReached())) return;
  const kept = await lastState.recall();
  if (kept !== null && store.state.mission === null) store.restore(kept);
}

async function isStationReached(): Promise<boolean> {
  try {
    const signal = AbortSignal.timeout(STATION_WITHIN_MS);
    const { status } = await fetch("/api/session", { signal, cache: "no-store" });
    return status !== 502 && status !== 504; // of a proxy before a station that is out of reach
  } catch {
    return false;
  }
}

/** Whether the station has another page than this one; null if it does not say. */
export async function isOutdated(): Promise<boolean | null> {
  if (!import.meta.env.PROD) return null; // built anew with every change
  try {
    const response = await fetch("/", { cache: "no-store", signal: AbortSignal.timeout(STATION_WITHIN_MS) });
    return response.ok ? !(await response.text()).includes(BUILD) : null;
  } catch {
    return null;
  }
}
