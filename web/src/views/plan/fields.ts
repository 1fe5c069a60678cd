/** Ranges and units of the numbers of a plan, as the station accepts them. */
import type { Forest, Plan } from "../../api/types";

type NumbersOf<T> = { [K in keyof T]-?: NonNullable<T[K]> extends number ? K : never }[keyof T];
export type NumberName = NumbersOf<Plan>;
export type ForestName = keyof Forest;

export interface NumberRule {
  readonly unit: string;
  readonly decimals: number;
  readonly step: number;
  readonly min?: number;
  readonly max?: number;
  /** Whether the station chooses a value when none is given. */
  readonly isOptional?: boolean;
}

export const HEADING: NumberRule = { unit: "°", decimals: 1, step: 1, min: 0, max: 359.9 };

export const PATTERN: readonly [NumberName, NumberRule][] = [
  ["vehicles", { unit: "", decimals: 0, step: 1, min: 1, max: 250 }],
  ["spacing_m", { unit: "m", decimals: 2, step: 0.5, min: 0.1, isOptional: true }],
  ["lowest_layer_m", { unit: "m", decimals: 1, step: 1, min: 5 }],
  ["layer_spacing_m", { unit: "m", decimals: 1, step: 0.5, min: 0.1 }],
  ["camera_fov_deg", { unit: "°", decimals: 1, step: 1, min: 1.1, max: 169.9 }],
];

/** Flight along the legs without stops. */
export const SWEEP: readonly [NumberName, NumberRule][] = [
  ["search_speed_mps", { unit: "m/s", decimals: 1, step: 0.5, min: 0.1 }],
  ["pod_percent", { unit: "%", decimals: 0, step: 5, min: 5, max: 99, isOptional: true }],
  ["line_spacing_m", { unit: "m", decimals: 1, step: 0.5, min: 0.1, isOptional: true }],
  ["leg_spacing_m", { unit: "m", decimals: 1, step: 1, min: 0.1, isOptional: true }],
  ["passes", { unit: "", decimals: 0, step: 1, min: 1, max: 3 }],
  ["rate_hz", { unit: "Hz", decimals: 1, step: 0.5, min: 0.1, max: 10 }],
];

export const LIMITS: readonly [NumberName, NumberRule][] = [
  ["floor_m", { unit: "m", decimals: 1, step: 1, isOptional: true }],
  ["ceiling_m", { unit: "m", decimals: 1, step: 1, isOptional: true }],
  ["fence_margin_m", { unit: "m", decimals: 1, step: 1, min: 0, isOptional: true }],
  ["cruise_speed_mps", { unit: "m/s", decimals: 1, step: 0.5, min: 0.1 }],
  ["battery_reserve_percent", { unit: "%", decimals: 0, step: 5, min: 0, max: 89 }],
  ["search_min", { unit: "min", decimals: 1, step: 1, min: 0.5 }],
  ["endurance_min", { unit: "min", decimals: 1, step: 1, min: 0.5 }],
];

export const FOREST: readonly [ForestName, NumberRule][] = [
  ["canopy_height_m", { unit: "m", decimals: 1, step: 1, min: 0.1 }],
  ["crown_base_m", { unit: "m", decimals: 1, step: 1, min: 0.1 }],
  ["occluder_size_m", { unit: "m", decimals: 2, step: 0.1, min: 0.01 }],
  ["occlusion", { unit: "", decimals: 2, step: 0.05, min: 0.01, max: 0.99 }],
];

/** Mature mixed forest, as initial values. */
export const NEW_FOREST: Forest = { canopy_height_m: 20, crown_base_m: 8, occluder_size_m: 1.4, occlusion: 0.85 };
