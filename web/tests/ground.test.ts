import { expect, test } from "vitest";
import { groundParts } from "../src/map/layers/ground";
import { PALETTES } from "../src/map/palette";

test("buildings and roads lie on water and woods, names on top", () => {
  const parts = groundParts(PALETTES.dark);
  const at = (layer: string) => parts.findIndex((part) => part["source-layer"] === layer);
  for (const [below, above] of [
    ["landcover", "water"],
    ["water", "building"],
    ["landuse", "roads"],
    ["transportation", "place"],
  ] as const)
    expect(at(below)).toBeLessThan(at(above));
});
