/** The hand-over on paper, and the flight log. */
import type { Notation } from "../coordinates";
import { texts } from "../texts";
import { type Answer, refused } from "./client";

/** Time after which a hand-over without an answer counts as lost: the station takes two minutes at most. */
const LOST_AFTER_MS = 180_000;
/** Where a screen is set to American English or the like, paper is Letter; everywhere else A4. */
const LETTER_REGIONS = ["US", "CA", "MX", "PH"];

export const FLIGHTS_URL = "/api/handover/flights.csv";

/** Address of the PDF in the notation, the time zone and the paper of this screen. */
export function handoverUrl(notation: Notation, locale = navigator.language): string {
  const time_zone = Intl.DateTimeFormat().resolvedOptions().timeZone || "UTC";
  const region = new Intl.Locale(locale).maximize().region ?? "";
  const paper = LETTER_REGIONS.includes(region) ? "letter" : "a4";
  return `/api/handover.pdf?${new URLSearchParams({ paper, notation, time_zone }).toString()}`;
}

/** Fetch the PDF; the station needs some seconds for its pictures. */
export async function readHandover(notation: Notation): Promise<Answer<Blob>> {
  try {
    const response = await fetch(handoverUrl(notation), { signal: AbortSignal.timeout(LOST_AFTER_MS) });
    if (response.ok) return { ok: true, value: await response.blob() };
    return await refused(response);
  } catch {
    return { ok: false, message: texts.requests.notSent };
  }
}
