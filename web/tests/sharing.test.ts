import { describe, expect, it } from "vitest";
import { sentText } from "../src/panels/sharing";

describe("what was shared", () => {
  it("says nothing before the first message", () => {
    expect(sentText({ sent_utc_s: null, lost: 0 })).toBe("");
  });

  it("tells the time of the latest message and what was given up", () => {
    expect(sentText({ sent_utc_s: 1_795_000_000, lost: 0 })).toMatch(/^Last sent \d\d:\d\d:\d\d .+\.$/);
    expect(sentText({ sent_utc_s: null, lost: 1 })).toBe("1 message given up.");
    expect(sentText({ sent_utc_s: 1_795_000_000, lost: 3 })).toMatch(/ 3 messages given up\.$/);
  });
});
