/** Draft of a finding's remarks, and what becomes of it when the station sends others. Pure functions. */
import type { Finding } from "../../api/types";

export type Remarks = Pick<Finding, "comment" | "assignee">;
export type RemarkName = keyof Remarks;
const REMARK_NAMES = ["comment", "assignee"] as const satisfies readonly RemarkName[];

export interface RemarksDraft {
  /** Finding of a mission that it belongs to. */
  readonly key: string;
  readonly typed: Remarks;
  /** Remarks that the station has sent last. */
  readonly stored: Remarks;
  /** Remarks that were sent to the station last, from this screen. */
  readonly sent: Remarks | null;
  /** Remarks that others have changed while they were being typed. */
  readonly overtaken: readonly RemarkName[];
}

export interface RemarksReading {
  readonly key: string;
  readonly stored: Remarks;
}

const freshDraft = ({ key, stored }: RemarksReading): RemarksDraft => ({
  key,
  typed: stored,
  stored,
  sent: null,
  overtaken: [],
});

/** Draft after the station has sent remarks: what is being typed stays, and the rest is shown as it is stored. */
export function afterRemarks(before: RemarksDraft | null, read: RemarksReading): RemarksDraft {
  if (before?.key !== read.key) return freshDraft(read);
  const { typed, stored, sent } = before;
  const isEdited = (name: RemarkName): boolean => typed[name] !== stored[name];
  const pick = (name: RemarkName): string => (isEdited(name) ? typed : read.stored)[name];
  const isOvertaken = (name: RemarkName): boolean => {
    if (!isEdited(name) || typed[name] === read.stored[name]) return false;
    if (read.stored[name] === stored[name]) return before.overtaken.includes(name);
    return read.stored[name] !== sent?.[name];
  };
  return {
    ...before,
    typed: { comment: pick("comment"), assignee: pick("assignee") },
    stored: read.stored,
    overtaken: REMARK_NAMES.filter(isOvertaken),
  };
}

/** Remarks that differ from what is stored; the others are not sent, so that they overwrite nothing. */
export const changedRemarks = ({ typed, stored }: RemarksDraft): Partial<Remarks> =>
  Object.fromEntries(REMARK_NAMES.filter((name) => typed[name] !== stored[name]).map((name) => [name, typed[name]]));
