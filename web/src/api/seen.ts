/** State of the mission that this page shows, by the name that the station gave it: commands carry it back. */
let shown: string | null = null;

export function noteSeen(name: string | null): void {
  if (name !== null) shown = name;
}

/** Header for requests that change something; the station refuses those based on a state that no longer holds. */
export const seenHeader = (): Record<string, string> => (shown === null ? {} : { [SEEN_HEADER]: shown });

export const SEEN_HEADER = "X-Seen";
