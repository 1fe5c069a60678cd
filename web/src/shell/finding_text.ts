/** A finding as one sentence of an alert or event: what, how likely, where in the chosen notation, how exact. */
import type { Finding } from "../api/types";
import { type Notation, written } from "../coordinates";
import { eastNorth, likelihood, quantity } from "../format";
import { texts } from "../texts";

/** A finding as it is spoken: what, how likely, and which one; where it is stands on the screen. */
export function spokenFinding({ kind, person_confidence: confidence, finding_id: id }: Finding): string {
  const likely = confidence === null ? "" : `, ${likelihood(confidence)}`;
  return `${texts.names.findingKind[kind]}${likely}. ${texts.decide.finding(id)}`;
}

/** What it is, and where, with its number at the end. */
export const findingText = (finding: Finding, notation: Notation): string =>
  `${findingWords(finding, notation)} · ${texts.decide.finding(finding.finding_id)}`;

/** What it is, and where. */
export function findingWords(finding: Finding, notation: Notation): string {
  const { kind, person_confidence: confidence, position, sigma_m } = finding;
  const { latitude_deg, longitude_deg, east_m, north_m } = position;
  const isPlaced = latitude_deg !== null && longitude_deg !== null;
  const place = isPlaced ? written({ latitude_deg, longitude_deg }, notation) : eastNorth(east_m, north_m);
  const likely = confidence === null ? "" : ` (${likelihood(confidence)})`;
  const error = sigma_m === null ? "" : `, ± ${quantity(sigma_m, 1, "m")}`;
  return `${texts.names.findingKind[kind]}${likely}, ${place}${error}`;
}
