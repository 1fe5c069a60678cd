/** Hook for a page that was opened without the station, or is older than it. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { Session } from "../api/types";
import type { State } from "../state/state";
import type { Store } from "../state/store";
import { isOutdated, lastState } from "./page";

/** Keep the last state as long as this screen may see it, and return whether the station has another page than this. */
export function useOffline(store: Store, { connection, keptAtMs }: State, session: Session | null): boolean {
  const [hasOtherPage, setOtherPage] = useState(false);
  const wasKept = useRef(false);
  if (keptAtMs !== null) wasKept.current = true;

  useEffect(() => {
    if (session === null) return;
    const isAdmitted = session.role !== "visitor";
    lastState.admit(isAdmitted);
    if (!isAdmitted) store.forgetRestored();
  }, [session?.role]);

  useEffect(() => {
    if (connection !== "open" && connection !== "incompatible") return;
    // On a page of the browser's cache nothing has been begun that a reload could lose.
    const mayReload = wasKept.current;
    wasKept.current = false;
    if (connection === "incompatible") {
      if (mayReload) location.reload();
      return;
    }
    void isOutdated().then((isOther) => {
      if (isOther === true && mayReload) location.reload();
      else setOtherPage(isOther === true);
    });
  }, [connection]);
  return hasOtherPage;
}
