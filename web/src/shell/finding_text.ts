/** A finding as one sentence of an alert or event: what, how likely, where in the chosen notation, how exact. */
import type { Finding } from "../api/types";
import { type Notation, written } from "../coordinates";
import { eastNorth, likelihood, quantity } from "../format";
import { texts } from "../texts";

export function findingText(finding: Finding, notation: Notation): string {
  const { kind, person_confidence: confidence, position, sigma_m, finding_id: id } = finding;
  const { latitude_deg, longitude_deg, east_m, north_m } = position;
  const isPlaced = latitude_deg !== null && longitude_deg !== null;
  const place = isPlaced ? written({ latitude_deg, longitude_deg }, notation) : eastNorth(east_m, north_m);
  const likely = confidence === null ? "" : ` (${likelihood(confidence)})`;
  const error = sigma_m === null ? "" : `, ± ${quantity(sigma_m, 1, "m")}`;
  return `${texts.names.findingKind[kind]}${likely}, ${place}${error} · ${texts.decide.finding(id)}`;
}
