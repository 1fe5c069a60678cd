/**
 * Small settings of this screen, kept in the browser. A browser whose storage is full or forbidden keeps them as long as
 * the page is open: a setting must never stop a sign-in or a command.
 */

const unsaved = new Map<string, string | null>();

/** Value that was stored last; null without one. */
export function readStored(key: string): string | null {
  const own = unsaved.get(key);
  if (own !== undefined) return own;
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

/** Store a value; null removes it. */
export function store(key: string, value: string | null): void {
  unsaved.delete(key);
  try {
    if (value === null) localStorage.removeItem(key);
    else localStorage.setItem(key, value);
  } catch {
    unsaved.set(key, value);
  }
}

/** Whether everything is stored: false as long as a value of this page could not be. */
export const isStorageWorking = (): boolean => unsaved.size === 0;
