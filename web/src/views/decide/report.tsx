/** Report of the findings of a mission, for printing. */
import type { Finding, Mission } from "../../api/types";
import { dateAndTime, duration, eastNorth, likelihood, quantity } from "../../format";
import { useShell } from "../../shell/context";
import { said, texts } from "../../texts";
import { type Fact, Facts } from "../../ui/facts";
import { ellipseText, notations, reported, sightingsText, significanceText, STATUS_SIGNS, timeText } from "./findings";
import "./report.css";
import { Sketch } from "./sketch";
import { Thumbnail } from "./thumbnail";

interface Props {
  mission: Mission;
  onClose(): void;
}

export function Report({ mission, onClose }: Props) {
  const { isSurvey } = useShell();
  const findings = reported(mission.findings);
  const ofFlight: Fact[] = [
    [texts.plan.strategy, mission.strategy],
    [texts.report.vehicles, String(mission.vehicles.length)],
    [texts.plan.coverage, quantity(mission.covered_percent, 0, "%")],
  ];
  // A result without where nothing could be found would be taken for a searched area.
  const ofSurvey: Fact[] = [[texts.survey.message, said(mission.message)]];
  const phase = isSurvey ? texts.survey.phase(mission.phase === "done") : texts.names.phase[mission.phase];
  const facts: Fact[] = [
    [isSurvey ? texts.survey.survey : texts.report.mission, mission.mission_id],
    [texts.report.printed, dateAndTime(Date.now() / 1000)],
    [texts.header.phase, phase],
    [texts.header.outcome, texts.names.outcome[mission.outcome]],
    [texts.report.started, mission.started_utc_s === null ? "" : dateAndTime(mission.started_utc_s)],
    [texts.header.elapsed, duration(mission.elapsed_s)],
    ...(isSurvey ? ofSurvey : ofFlight),
    [texts.report.findings, String(findings.length)],
  ];
  return (
    <article class="report panel scroll" data-testid="report" aria-label={texts.report.title}>
      <div class="button-row no-print">
        <button type="button" class="primary" data-testid="report-print" onClick={() => window.print()}>
          {texts.report.print}
        </button>
        <button type="button" data-testid="report-close" onClick={onClose}>
          {texts.report.close}
        </button>
      </div>
      <h2>{texts.report.title}</h2>
      <div class="report-head">
        <Facts facts={facts} />
        <Sketch mission={mission} />
      </div>
      {findings.length === 0 && <p>{texts.decide.none.all}</p>}
      {findings.length > 0 && <p class="small">{isSurvey ? texts.survey.datum : texts.report.datum}</p>}
      {findings.map((finding) => (
        <ReportedFinding key={finding.finding_id} finding={finding} />
      ))}
    </article>
  );
}

function ReportedFinding({ finding }: { finding: Finding }) {
  const { notation, state } = useShell();
  const { finding_id: id, status, position, person_confidence, kind, reasons, comment, assignee, operator } = finding;
  const facts: Fact[] = [
    ...notations(finding, notation).map(([name, text]): Fact => [texts.places.notation[name], text]),
    [texts.decide.local, eastNorth(position.east_m, position.north_m)],
    [texts.decide.ellipse, ellipseText(finding)],
    [texts.decide.views, sightingsText(finding)],
    [texts.decide.kind, texts.names.findingKind[kind]],
    [texts.decide.confidence, likelihood(person_confidence)],
    [texts.decide.significance, significanceText(finding)],
    [texts.decide.reasons, reasons.map(said).join("; ")],
    [texts.decide.found, timeText(finding, finding.found_at_s, state.mission)],
    [texts.decide.seen, timeText(finding, finding.seen_at_s, state.mission)],
    [texts.report.decidedBy, status === "new" ? "" : operator],
    [texts.decide.assignee, assignee],
    [texts.decide.comment, comment],
  ];
  return (
    <section class="report-finding" data-testid={`report-finding-${id}`}>
      <h3>
        {texts.decide.finding(id)}: {STATUS_SIGNS[status]} {texts.decide.status[status]}
      </h3>
      <Facts facts={facts} />
      <Thumbnail finding={finding} shot={{ kind: "integral" }} />
      <Thumbnail finding={finding} shot={{ kind: "thermal" }} />
    </section>
  );
}
