/** Selected vehicles. Pure functions; ids are in the order of the fleet table. */

export interface Selection {
  readonly ids: ReadonlySet<number>;
  /** Start of a range selected with the Shift key. */
  readonly anchor: number | null;
  /** Digits typed so far, and the time of the last one. */
  readonly typed: { readonly digits: string; readonly atMs: number };
}

/** Longest pause between the digits of one number: 1, 2 selects vehicle 12. */
export const TYPING_PAUSE_MS = 800;

export const NO_SELECTION: Selection = { ids: new Set(), anchor: null, typed: { digits: "", atMs: -Infinity } };

/** Add or remove a vehicle. */
export function toggle(selection: Selection, id: number): Selection {
  const ids = new Set(selection.ids);
  if (!ids.delete(id)) ids.add(id);
  return { ...selection, ids, anchor: id };
}

/** Add all vehicles from the anchor to `id`, in the order of the table. */
export function extend(selection: Selection, id: number, fleet: readonly number[]): Selection {
  const [from, to] = [fleet.indexOf(selection.anchor ?? id), fleet.indexOf(id)];
  if (from < 0 || to < 0) return toggle(selection, id);
  const range = fleet.slice(Math.min(from, to), Math.max(from, to) + 1);
  return { ...selection, ids: new Set([...selection.ids, ...range]) };
}

/** Select exactly these vehicles. */
export function select(selection: Selection, ids: Iterable<number>): Selection {
  return { ...selection, ids: new Set(ids), anchor: null };
}

/** Process a digit of a vehicle number: select that vehicle alone, or add it. Unknown numbers select nothing. */
export function typeDigit(
  selection: Selection,
  stroke: { digit: string; adds: boolean },
  fleet: readonly number[],
  nowMs: number,
): Selection {
  const isContinued = nowMs - selection.typed.atMs <= TYPING_PAUSE_MS;
  const before = isContinued ? selection.typed.digits : "";
  const longer = before + stroke.digit;
  const digits = fleet.includes(Number(longer)) || before === "" ? longer : stroke.digit;
  const id = Number(digits);
  const typed = { digits, atMs: nowMs };
  if (!fleet.includes(id)) return { ...selection, typed };
  const kept = new Set(stroke.adds ? selection.ids : []);
  // A longer number replaces the shorter one that its first digits have selected.
  if (digits.length > 1) kept.delete(Number(before));
  return { ids: new Set([...kept, id]), anchor: id, typed };
}

/** Remove vehicles that are no longer in the fleet. */
export function retain(selection: Selection, fleet: readonly number[]): Selection {
  const kept = [...selection.ids].filter((id) => fleet.includes(id));
  return kept.length === selection.ids.size ? selection : { ...selection, ids: new Set(kept) };
}
