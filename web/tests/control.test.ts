import { describe, expect, test } from "vitest";
import type { Control } from "../src/api/types";
import { controlView } from "../src/state/control";

const control = (changes: Partial<Control>): Control => ({
  holder: "Robin",
  holder_present: true,
  operators: ["Ada", "Robin"],
  requests: [],
  ...changes,
});

describe("who has control", () => {
  test("an operator who is alone is shown nothing", () => {
    expect(controlView(null, "Ada")).toBeNull();
    expect(controlView(control({}), "")).toBeNull();
    expect(controlView(control({ holder: "Ada", operators: ["Ada"] }), "Ada")).toBeNull();
    expect(controlView(control({ holder: null, holder_present: false, operators: ["Ada"] }), "Ada")).toBeNull();
  });

  test("the one in control sees who asks", () => {
    expect(controlView(control({ requests: ["Ada"] }), "Robin")).toMatchObject({ isMine: true, asking: "Ada" });
  });

  test("the others see who has control, and whether that operator is gone", () => {
    expect(controlView(control({ requests: ["Ada"] }), "Ada")).toEqual({
      other: "Robin",
      isMine: false,
      isFree: false,
      asking: null,
      haveAsked: true,
    });
    const gone = control({ holder_present: false, operators: ["Ada"] });
    expect(controlView(gone, "Ada")).toMatchObject({ other: "Robin", isFree: true });
  });

  test("control that nobody has is free", () => {
    expect(controlView(control({ holder: null, holder_present: false }), "Ada")).toMatchObject({
      other: null,
      isFree: true,
    });
  });
});
