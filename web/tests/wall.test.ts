import { describe, expect, test } from "vitest";
import { NOTHING, parseWallMessage, tileAge_s, type WallMessage, type WallState } from "../src/api/wall";
import { columnsFor, firstTiles, tileOf, titleOf } from "../src/views/wall/tiles";

const HEAD: WallMessage = {
  number: 3,
  sent_s: 100,
  live: true,
  stale_s: 5,
  rate_hz: 2,
  tiles: ["1.thermal"],
  ages_s: { "1.thermal": 2 },
  pictures: [],
  refused: "",
};
const PICTURE = {
  tile: "1.thermal",
  bytes: 3,
  width_px: 320,
  height_px: 240,
  utc_s: 1e9,
  latitude_deg: 48,
  longitude_deg: 14,
  at_camera: false,
  palette: "inferno",
  scale: null,
};

function message(head: unknown, files: readonly number[] = []): ArrayBuffer {
  const text = new TextEncoder().encode(JSON.stringify(head));
  const bytes = new Uint8Array(4 + text.length + files.length);
  new DataView(bytes.buffer).setUint32(0, text.length);
  bytes.set(text, 4);
  bytes.set(files, 4 + text.length);
  return bytes.buffer;
}

describe("messages", () => {
  test("have a head and the files that it names", async () => {
    const parsed = parseWallMessage(message({ ...HEAD, pictures: [PICTURE] }, [7, 8, 9]));
    expect(parsed?.head.number).toBe(3);
    expect([...new Uint8Array((await parsed?.files[0]?.arrayBuffer()) ?? new ArrayBuffer(0))]).toEqual([7, 8, 9]);
  });
  test.each([
    ["nothing", new ArrayBuffer(0)],
    ["no head", message({ number: 1 })],
    ["less than it names", message({ ...HEAD, pictures: [PICTURE] }, [7])],
    ["more than it names", message(HEAD, [7])],
    ["no JSON", new Uint8Array([0, 0, 0, 1, 123]).buffer],
  ])("with %s are none", (_, data) => {
    expect(parseWallMessage(data)).toBeNull();
  });
});

describe("ages", () => {
  const state: WallState = { ...NOTHING, head: HEAD, sentAtMs: 1000 };
  test("grow from the sending on, the way of the message included", () => {
    expect(tileAge_s(state, "1.thermal", 4500)).toBe(5.5);
  });
  test("stand still in a replay", () => {
    expect(tileAge_s({ ...state, head: { ...HEAD, live: false } }, "1.thermal", 99_000)).toBe(2);
  });
  test("are unknown without a picture", () => {
    expect(tileAge_s(state, "2.thermal", 4500)).toBeNull();
    expect(tileAge_s(NOTHING, "1.thermal", 0)).toBeNull();
  });
});

describe("tiles", () => {
  test("are named as the station names them", () => {
    expect(tileOf("12.colour")).toEqual({ name: "12.colour", vehicleId: 12, kind: "colour" });
    expect(titleOf({ name: "all.thermal", vehicleId: null, kind: "thermal" })).toBe("Integral, thermal");
    for (const name of ["", "1", "1.depth", "x.colour", "1.colour "]) expect(tileOf(name)).toBeNull();
  });
  test("of a new screen are the integrals and the first cameras, by temperatures where they have them", () => {
    const there = ["all.colour", "all.thermal", "1.colour", "1.thermal", "2.colour", "3.thermal"];
    expect(firstTiles(there)).toEqual(["all.colour", "all.thermal", "1.thermal", "2.colour", "3.thermal"]);
    expect(firstTiles([...Array(20).keys()].map((id) => `${id}.colour`))).toHaveLength(6);
  });
  test("are as large as the space allows", () => {
    expect(columnsFor(6, 1600, 900, 165)).toBe(3);
    expect(columnsFor(1, 1600, 900, 165)).toBe(1);
    expect(columnsFor(24, 1600, 900, 165)).toBe(8);
    expect(columnsFor(6, 360, 500, 165)).toBe(2);
    expect(columnsFor(0, 100, 100, 165)).toBe(1);
  });
});
