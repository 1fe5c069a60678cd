import { describe, expect, it } from "vitest";
import { sentText } from "../src/panels/sharing";

const NONE = { refused: 0, refused_text: "" };

describe("what was shared", () => {
  it("says nothing before the first message", () => {
    expect(sentText({ sent_utc_s: null, lost: 0, ...NONE })).toBe("");
  });

  it("tells the time of the latest message and what was given up", () => {
    expect(sentText({ sent_utc_s: 1_795_000_000, lost: 0, ...NONE })).toMatch(/^Last sent \d\d:\d\d:\d\d .+\.$/);
    expect(sentText({ sent_utc_s: null, lost: 1, ...NONE })).toBe("1 message not delivered.");
    expect(sentText({ sent_utc_s: 1_795_000_000, lost: 3, ...NONE })).toMatch(/ 3 messages not delivered\.$/);
  });

  it("tells what others have sent that could not be used", () => {
    const refused = { sent_utc_s: null, lost: 0, refused: 2, refused_text: "LKP: latitude 95" };
    expect(sentText(refused)).toBe("2 incoming messages rejected. Latest: LKP: latitude 95.");
  });
});
