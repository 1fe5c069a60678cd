/** Content and order of the list of findings. Pure functions. */
import type { Finding, FindingStatus, Mission } from "../../api/types";
import { type Notation, NOTATIONS, written } from "../../coordinates";
import { amount, duration, likelihood, quantity, timeOfDay } from "../../format";
import { texts } from "../../texts";

export const STATUS_SIGNS: Readonly<Record<FindingStatus, string>> = { new: "?", confirmed: "✓", rejected: "✗" };

export const FILTERS = ["open", "confirmed", "rejected", "all"] as const;
export type Filter = (typeof FILTERS)[number];

type Ranks = Readonly<Record<FindingStatus, number>>;

/**
 * Findings in the order of the list: undecided first, then the latest seen, or in a survey the surest possible persons;
 * merged ones are among all only.
 */
export function listed(findings: readonly Finding[], filter: Filter): Finding[] {
  const wanted = filter === "open" ? "new" : filter;
  const shown = wanted === "all" ? findings : counting(findings).filter(({ status }) => status === wanted);
  return ranked(shown, { new: 0, confirmed: 1, rejected: 2 });
}

/** Findings in the order of the report: confirmed first; merged ones are left out. */
export const reported = (findings: readonly Finding[]): Finding[] =>
  ranked(counting(findings), { confirmed: 0, new: 1, rejected: 2 });

/** Findings that have not turned out to be an earlier one. */
export const counting = (findings: readonly Finding[]): Finding[] =>
  findings.filter(({ merged_into }) => merged_into === null);

/** Operators' judgement, or the finding that counts instead. */
export const statusText = ({ status, merged_into: same }: Finding): string =>
  same === null ? `${STATUS_SIGNS[status]} ${texts.decide.status[status]}` : texts.decide.sameAs(same);

const ranked = (findings: readonly Finding[], ranks: Ranks): Finding[] =>
  [...findings].sort(
    (a, b) =>
      ranks[a.status] - ranks[b.status] ||
      kindRank(a) - kindRank(b) ||
      // Not a number where neither has one, as in missions: then the next rule decides.
      (b.significance ?? Infinity) - (a.significance ?? Infinity) ||
      b.seen_at_s - a.seen_at_s ||
      a.finding_id - b.finding_id,
  );

/** Findings of a survey that may be persons come before what is only warm; what an operator has marked comes first. */
function kindRank({ significance, kind }: Finding): number {
  if (significance === null) return 0;
  return kind === "person" || kind === "anomaly" ? 1 : 2;
}

/** Number of sightings, in a survey of frames; positions marked by an operator have none. */
export function sightingsText({ track_id, sightings, significance, found_in }: Finding): string {
  if (track_id === null && (found_in === "" || sightings === 0)) return texts.noData;
  return significance === null ? texts.target.sightings(sightings) : texts.survey.frames(sightings);
}

/**
 * Time at which a finding was first or last seen: by the clock, with the time of the mission behind it, or that alone
 * where no clock time is known; or that another sortie has found it.
 */
export function timeText(
  { found_in }: Finding,
  time_s: number,
  mission: Pick<Mission, "started_utc_s"> | null,
): string {
  if (found_in !== "") return texts.decide.earlierSortie;
  const started_utc_s = mission?.started_utc_s ?? null;
  return started_utc_s === null ? duration(time_s) : `${timeOfDay(started_utc_s + time_s)} (${duration(time_s)})`;
}

/** Position in the notations that search teams use, the chosen one first; none without an origin on the globe. */
export function notations({ position }: Finding, chosen: Notation): [Notation, string][] {
  const { latitude_deg, longitude_deg } = position;
  if (latitude_deg === null || longitude_deg === null) return [];
  const ordered = [chosen, ...NOTATIONS.filter((notation) => notation !== chosen)];
  const all = ordered.map((name): [Notation, string] => [name, written({ latitude_deg, longitude_deg }, name)]);
  // Beyond the reach of UTM several notations are the same.
  return all.filter(([, text], index) => all.findIndex(([, other]) => other === text) === index);
}

/** How surely a survey shows a finding; nothing in missions. */
export const significanceText = ({ significance }: Finding): string =>
  significance === null ? "" : quantity(significance, 1);

/** What a finding rests on: the probability of a person, or where none is known the significance. */
export const evidenceText = (finding: Finding): string =>
  finding.person_confidence === null && finding.significance !== null
    ? `${texts.decide.significance}: ${significanceText(finding)}`
    : `${texts.decide.confidence}: ${likelihood(finding.person_confidence)}`;

/** Half axes and heading of the error ellipse of one standard deviation. */
export function ellipseText({ ellipse, sigma_m }: Finding): string {
  if (ellipse === null) return quantity(sigma_m, 1, "m");
  const { semi_major_m, semi_minor_m, heading_deg } = ellipse;
  return `${amount(semi_major_m, 1, "m")} × ${quantity(semi_minor_m, 1, "m")}, ${quantity(heading_deg, 0, "°")}`;
}
