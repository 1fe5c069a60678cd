import { describe, expect, it, test } from "vitest";
import { NOTATIONS, readPlace, written } from "../src/coordinates";

const ZURICH = { latitude_deg: 47.3913, longitude_deg: 8.5432 };
const SYDNEY = { latitude_deg: -33.85678, longitude_deg: 151.21534 };

describe("places are written", () => {
  // As the station's exports write them, by the Python packages utm and mgrs.
  test.each([
    ["decimal", ZURICH, "47.391300° N, 8.543200° E"],
    ["dms", ZURICH, `47°23'28.68"N 8°32'35.52"E`],
    ["utm", ZURICH, "32T 465526 5248750"],
    ["mgrs", ZURICH, "32T MT 65525 48750"],
    ["decimal", SYDNEY, "33.856780° S, 151.215340° E"],
    ["dms", SYDNEY, `33°51'24.41"S 151°12'55.22"E`],
    ["utm", SYDNEY, "56H 334904 6252291"],
    ["mgrs", SYDNEY, "56H LH 34904 52291"],
  ] as const)("in %s", (notation, place, text) => {
    expect(written(place, notation)).toBe(text);
  });

  it("carries seconds over and keeps the sign of small angles", () => {
    expect(written({ latitude_deg: -0.0000001, longitude_deg: 9.99999999 }, "dms")).toBe(`0°00'00.00"S 10°00'00.00"E`);
  });

  it("uses degrees beyond the reach of UTM", () => {
    expect(written({ latitude_deg: 85, longitude_deg: 0 }, "mgrs")).toBe("85.000000° N, 0.000000° E");
  });
});

describe("places are read", () => {
  test.each([
    "47.3913, 8.5432",
    "47.3913 8.5432",
    "47.3913;8.5432",
    "47,3913 8,5432",
    "47,3913; 8,5432",
    "47.3913° N, 8.5432° E",
    "8.5432 E 47.3913 N",
    "N47.3913 E8.5432",
    "n 47° 23.478' e 8° 32.592'",
    `47°23'28.68"N 8°32'35.52"E`,
    "47 23 28.68 N, 8 32 35.52 E",
    "47°23′28.68″N 8°32′35.52″E",
    "32T 465526 5248750",
    "32 N 465526mE 5248750mN",
    "32T MT 65525 48750",
    "32tmt6552548750",
  ])("from %s", (text) => {
    const place = readPlace(text);
    expect(place?.latitude_deg).toBeCloseTo(ZURICH.latitude_deg, 4);
    expect(place?.longitude_deg).toBeCloseTo(ZURICH.longitude_deg, 4);
  });

  test.each([
    "",
    "here",
    "47.3913",
    "91, 8",
    "47, 181",
    "47.3913 N, 8.5432 N",
    "47.3913, 8.5432, 400",
    "61T 465513 5248742",
    "32T 65513 5248742",
    "32T MT 655 48742",
    "32I MT 65513 48742",
    "32T AA 65513 48742",
  ])("not from %s", (text) => {
    expect(readPlace(text)).toBeNull();
  });

  it("takes S for the band or the hemisphere by the northing", () => {
    expect(readPlace("33S 500000 3900000")?.latitude_deg).toBeCloseTo(35.24, 1);
    expect(readPlace("33S 500000 6252288")?.latitude_deg).toBeLessThan(0);
  });

  it("reads what is written, to the metre, over the globe", () => {
    for (let latitude_deg = -79.5; latitude_deg < 84; latitude_deg += 3.7)
      for (let longitude_deg = -179.3; longitude_deg < 180; longitude_deg += 7.9)
        for (const notation of NOTATIONS) {
          const place = { latitude_deg, longitude_deg };
          const again = readPlace(written(place, notation));
          const scale = Math.cos((latitude_deg * Math.PI) / 180);
          expect(again, written(place, notation)).not.toBeNull();
          const north_m = 111_000 * ((again?.latitude_deg ?? 0) - latitude_deg);
          const east_m = 111_000 * scale * ((again?.longitude_deg ?? 0) - longitude_deg);
          expect(Math.hypot(north_m, east_m), written(place, notation)).toBeLessThan(1.1);
        }
  });
});
