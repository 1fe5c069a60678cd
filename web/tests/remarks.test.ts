import { expect, test } from "vitest";
import { afterRemarks, changedRemarks, type Remarks, type RemarksDraft } from "../src/views/decide/remarks";

const NOTHING: Remarks = { comment: "", assignee: "" };
const begun = afterRemarks(null, { key: "a 1", stored: NOTHING });
const typing = (before: RemarksDraft, typed: Partial<Remarks>): RemarksDraft => ({
  ...before,
  typed: { ...before.typed, ...typed },
});
const saving = (before: RemarksDraft): RemarksDraft => ({ ...before, sent: before.typed });
const reading = (before: RemarksDraft, stored: Partial<Remarks>): RemarksDraft =>
  afterRemarks(before, { key: before.key, stored: { ...before.stored, ...stored } });

test("what is typed while the station answers stays, and is not taken for another operator's", () => {
  const sent = saving(typing(begun, { comment: "lies still" }));
  const answered = reading(typing(sent, { comment: "lies still, breathes" }), { comment: "lies still" });
  expect(answered.typed.comment).toBe("lies still, breathes");
  expect(answered.overtaken).toEqual([]);
  expect(changedRemarks(answered)).toEqual({ comment: "lies still, breathes" });
});

test("what another operator has saved is shown where nothing is being typed, and told where something is", () => {
  const read = reading(typing(begun, { comment: "lies still" }), { comment: "moves", assignee: "team 2" });
  expect(read.typed).toEqual({ comment: "lies still", assignee: "team 2" });
  expect(read.overtaken).toEqual(["comment"]);
  expect(reading(read, { assignee: "team 3" }).overtaken).toEqual(["comment"]);
  expect(changedRemarks(read)).toEqual({ comment: "lies still" });
  const saved = reading(saving(read), { comment: "lies still" });
  expect(saved.overtaken).toEqual([]);
  expect(reading(saved, { comment: "moves" }).typed.comment).toBe("moves");
});

test("remarks of another finding are its own", () => {
  const other = { key: "a 2", stored: { comment: "warm stone", assignee: "" } };
  expect(afterRemarks(typing(begun, { comment: "lies still" }), other).typed).toEqual(other.stored);
});
