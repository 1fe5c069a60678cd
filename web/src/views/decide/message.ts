/** A finding in words, as it is sent on by text message or radio. Pure functions. */
import type { Finding, Mission } from "../../api/types";
import type { Notation } from "../../coordinates";
import { likelihood } from "../../format";
import { said, texts } from "../../texts";
import { ellipseText, notations, timeText } from "./findings";
import { type Reference, wayTo } from "./way";

/** Lines of the message: what, where in the chosen notation and in degrees, how exact, which way, when, why. */
export function messageAbout(finding: Finding, mission: Mission, notation: Notation, reference: Reference): string {
  const { finding_id: id, kind, person_confidence, status, reasons, assignee, comment } = finding;
  const likely = person_confidence === null ? "" : ` (${likelihood(person_confidence)})`;
  const places = notations(finding, notation).filter(([name]) => name === notation || name === "decimal");
  const lines = [
    `${texts.names.findingKind[kind]}${likely}, ${texts.decide.finding(id).toLowerCase()}, ${texts.names.finding[status]}`,
    ...places.map(([name, text]) => `${text} (${texts.places.notation[name]}, WGS 84)`),
    `${texts.decide.ellipse}: ${ellipseText(finding)}`,
    wayTo(finding, mission, reference),
    `${texts.decide.found}: ${timeText(finding, finding.found_at_s, mission)}`,
    `${texts.decide.seen}: ${timeText(finding, finding.seen_at_s, mission)}`,
    reasons.length > 0 ? `${texts.decide.reasons}: ${reasons.map(said).join("; ")}` : null,
    assignee === "" ? null : `${texts.decide.assignee}: ${assignee}`,
    comment === "" ? null : `${texts.decide.comment}: ${comment}`,
    `${texts.report.mission}: ${mission.mission_id}`,
  ];
  return lines.filter((line) => line !== null).join("\n");
}
