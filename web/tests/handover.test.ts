import { describe, expect, it } from "vitest";
import { handoverUrl } from "../src/api/handover";

describe("the address of the hand-over", () => {
  const paper = (locale: string): string | null =>
    new URL(handoverUrl("mgrs", locale), "http://station").searchParams.get("paper");

  it("asks for the paper of the screen's region", () => {
    expect(["en-US", "en", "de-AT", "en-GB", "es-MX", "pl"].map(paper)).toEqual([
      "letter",
      "letter",
      "a4",
      "a4",
      "letter",
      "a4",
    ]);
  });

  it("names notation and time zone of the screen", () => {
    const asked = new URL(handoverUrl("dms", "de"), "http://station").searchParams;
    expect(asked.get("notation")).toBe("dms");
    expect(asked.get("time_zone")).toBe(Intl.DateTimeFormat().resolvedOptions().timeZone);
  });
});
