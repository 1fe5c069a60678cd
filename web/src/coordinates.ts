/** Places on the globe as search teams write them. All notations are WGS 84. */
import Dms from "geodesy/dms.js";
import Mgrs, { LatLon } from "geodesy/mgrs.js";
import Utm from "geodesy/utm.js";
import type { Place } from "./api/types";
import { readStored, store } from "./storage";

export const NOTATIONS = ["decimal", "dms", "utm", "mgrs"] as const;
export type Notation = (typeof NOTATIONS)[number];

const KEY = "aos-gcs-notation";

/** Latitudes where the letter S is a band of UTM, which lies north of the equator, by their northings. */
const BAND_S_NORTHINGS_M = [3_530_000, 4_440_000] as const;
const HALF = String.raw`([-+]?\d[\d\s.°º'′’"″”]*)`;
const LETTER_LAST = new RegExp(String.raw`^${HALF}([NSEW])[\s,;]*${HALF}([NSEW])$`);
const LETTER_FIRST = new RegExp(String.raw`^([NSEW])\s*${HALF}[\s,;]*([NSEW])\s*${HALF}$`);
const UTM = /^(\d{1,2})\s*([C-HJ-NP-X])\s+(\d{6}(?:\.\d+)?)\s*M?\s*E?[\s,;]+(\d{1,8}(?:\.\d+)?)\s*M?\s*N?$/;
const MGRS = /^(\d{1,2})\s*([C-HJ-NP-X])\s*([A-HJ-NP-Z]{2})\s*(\d{1,5}\s+\d{1,5}|\d{2,10})$/;

export function storedNotation(): Notation {
  return NOTATIONS.find((notation) => notation === readStored(KEY)) ?? "decimal";
}

export function storeNotation(notation: Notation): void {
  store(KEY, notation);
}

/** Place in a notation; nearer to the poles than UTM reaches, in decimal degrees. */
export function written({ latitude_deg, longitude_deg }: Place, notation: Notation): string {
  if (notation === "dms") return `${dms(latitude_deg, "N", "S")} ${dms(longitude_deg, "E", "W")}`;
  if (notation === "decimal" || latitude_deg < -80 || latitude_deg > 84) return decimal(latitude_deg, longitude_deg);
  const utm = new LatLon(latitude_deg, longitude_deg).toUtm();
  const mgrs = utm.toMgrs();
  if (notation === "mgrs") return mgrs.toString(10);
  return `${mgrs.zone}${mgrs.band} ${utm.easting.toFixed(0)} ${utm.northing.toFixed(0)}`;
}

/** Place of a text in any of the notations; null if it is none of them. */
export function readPlace(text: string): Place | null {
  const plain = text.trim().toUpperCase();
  try {
    const place = readMgrs(plain) ?? readUtm(plain) ?? readDegrees(plain);
    return place !== null && isOnGlobe(place) ? place : null;
  } catch (error) {
    // What the library refuses: a zone, band or square that does not exist, or an easting outside of its zone.
    if (error instanceof Error) return null;
    throw error;
  }
}

function decimal(latitude_deg: number, longitude_deg: number): string {
  const half = (value: number, plus: string, minus: string): string =>
    `${Math.abs(value).toFixed(6)}° ${value >= 0 ? plus : minus}`;
  return `${half(latitude_deg, "N", "S")}, ${half(longitude_deg, "E", "W")}`;
}

function dms(angle_deg: number, plus: string, minus: string): string {
  const hundredths = Math.round(Math.abs(angle_deg) * 360_000);
  const minutes = String(Math.floor(hundredths / 6_000) % 60).padStart(2, "0");
  const seconds = ((hundredths % 6_000) / 100).toFixed(2).padStart(5, "0");
  return `${Math.floor(hundredths / 360_000)}°${minutes}'${seconds}"${angle_deg < 0 ? minus : plus}`;
}

function readMgrs(text: string): Place | null {
  const [, zone, band, square, digits] = MGRS.exec(text) ?? [];
  if (!zone || !band || !square || !digits) return null;
  const half = Math.ceil(digits.length / 2);
  const [east, north] = digits.includes(" ") ? digits.split(/\s+/) : [digits.slice(0, half), digits.slice(half)];
  if (!east || !north || east.length !== north.length) return null;
  const size_m = 10 ** (5 - east.length);
  // The middle of the square, which is the best guess of what it stands for.
  const [easting, northing] = [(Number(east) + 0.5) * size_m, (Number(north) + 0.5) * size_m];
  const [column, row] = [square.charAt(0), square.charAt(1)];
  return placeOf(new Mgrs(Number(zone), band, column, row, easting, northing).toUtm());
}

function readUtm(text: string): Place | null {
  const [, zone, letter, easting, northing] = UTM.exec(text) ?? [];
  if (!zone || !letter) return null;
  const [lowest_m, highest_m] = BAND_S_NORTHINGS_M;
  const isBandS = Number(northing) >= lowest_m && Number(northing) <= highest_m;
  const isNorth = letter >= "N" && (letter !== "S" || isBandS);
  return placeOf(new Utm(Number(zone), isNorth ? "N" : "S", Number(easting), Number(northing)));
}

function readDegrees(text: string): Place | null {
  const last = LETTER_LAST.exec(text);
  if (last !== null) return lettered([last[1], last[2]], [last[3], last[4]]);
  const first = LETTER_FIRST.exec(text);
  if (first !== null) return lettered([first[2], first[1]], [first[4], first[3]]);
  // Without a point, commas between digits are decimal ones.
  const points = text.includes(".") ? text : text.replaceAll(/(\d),(\d)/g, "$1.$2");
  const [latitude, longitude, ...others] = points.split(/\s*[,;]\s*|\s+/);
  if (latitude === undefined || longitude === undefined || others.length > 0) return null;
  return { latitude_deg: Dms.parse(latitude), longitude_deg: Dms.parse(longitude) };
}

type Half = readonly [angle: string | undefined, letter: string | undefined];

/** Latitude and longitude in the order that their letters tell. */
function lettered(one: Half, other: Half): Place | null {
  const isLatitude = ([, letter]: Half): boolean => letter === "N" || letter === "S";
  if (isLatitude(one) === isLatitude(other)) return null;
  const [latitude, longitude] = isLatitude(one) ? [one, other] : [other, one];
  const angle_deg = ([angle = "", letter = ""]: Half): number => Dms.parse(`${angle.trim()}${letter}`);
  return { latitude_deg: angle_deg(latitude), longitude_deg: angle_deg(longitude) };
}

const placeOf = (utm: Utm): Place => {
  const { lat, lon } = utm.toLatLon();
  return { latitude_deg: lat, longitude_deg: lon };
};

// False for what is not a number, too.
const isOnGlobe = ({ latitude_deg, longitude_deg }: Place): boolean =>
  Math.abs(latitude_deg) <= 90 && Math.abs(longitude_deg) <= 180;
