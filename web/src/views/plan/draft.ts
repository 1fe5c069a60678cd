/** Draft of a mission's plan, and what becomes of it when the plan of the mission is read again or applied. */
import type { Plan } from "../../api/types";
import { begun, type History } from "./history";

export interface Draft {
  readonly missionId: string;
  readonly history: History;
  /** Plan of the mission, as far as the draft is based on it. */
  readonly flown: Plan;
  /** Revision of the mission's plan that was read last. */
  readonly revision: number;
  /** Whether the mission had another plan than `flown` when it was read last. */
  readonly isOvertaken: boolean;
}

export interface Reading {
  readonly missionId: string;
  readonly plan: Plan;
  readonly revision: number;
}

/** Revision of no plan: it has to be read. */
const UNREAD = -1;

export const isEdited = (draft: Draft | null): boolean => draft !== null && draft.history.plan !== draft.flown;

const freshDraft = ({ missionId, plan, revision }: Reading): Draft => ({
  missionId,
  history: begun(plan),
  flown: plan,
  revision,
  isOvertaken: false,
});

/** Draft after the plan has been read. Edits are kept, also those made while the station answered. */
export function afterReading(before: Draft | null, read: Reading): Draft {
  if (before === null || before.missionId !== read.missionId) return freshDraft(read);
  const isOvertaken = !isSamePlan(before.flown, read.plan);
  if (isOvertaken && !isEdited(before)) return freshDraft(read);
  return { ...before, revision: read.revision, isOvertaken };
}

/** Draft after `sent` has become the plan of the mission. Edits made while the station answered are kept. */
export function afterApplying(before: Draft, sent: Plan, applied: Plan): Draft {
  const history = before.history.plan === sent ? begun(applied) : before.history;
  return { ...before, history, flown: applied, isOvertaken: false };
}

/** Draft without its edits; what the mission has instead is still to be read. */
export const afterDiscarding = (before: Draft): Draft => ({
  ...before,
  history: begun(before.flown),
  revision: UNREAD,
});

/** Both as the station sends them, with their fields in its order. */
const isSamePlan = (one: Plan, other: Plan): boolean => JSON.stringify(one) === JSON.stringify(other);

/** Keeps the draft while another view is open: answers that come then change it as well. */
export class DraftKeeper {
  private draft: Draft | null = null;
  private readonly readers = new Set<(draft: Draft | null) => void>();

  /** The draft of a mission; drafts of others are forgotten. */
  of(missionId: string): Draft | null {
    if (this.draft?.missionId !== missionId) this.draft = null;
    return this.draft;
  }

  /** Put the draft of a reading in place of the present one. */
  read(reading: Reading): void {
    this.put(afterReading(this.draft, reading));
  }

  /** Change the draft of a mission, unless it is gone. */
  change(missionId: string, take: (before: Draft) => Draft): void {
    if (this.draft?.missionId === missionId) this.put(take(this.draft));
  }

  /** Call `reader` with the draft now and after changes, until the returned function is called. */
  subscribe(reader: (draft: Draft | null) => void): () => void {
    this.readers.add(reader);
    reader(this.draft);
    return () => void this.readers.delete(reader);
  }

  private put(draft: Draft): void {
    this.draft = draft;
    for (const reader of this.readers) reader(draft);
  }
}
