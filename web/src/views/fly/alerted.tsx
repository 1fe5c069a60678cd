/**
 * Card of the possible person that an alert is about, on the map: pictures, where it is, and the decision, without
 * leaving the flight. It stays until it is closed, or decided and another one is waiting.
 */
import { useRef, useState } from "preact/hooks";
import type { Finding } from "../../api/types";
import { useShell } from "../../shell/context";
import { findingText } from "../../shell/finding_text";
import { routeHash } from "../../shell/route";
import { undecidedAlerted } from "../../state/findings";
import { said, texts } from "../../texts";
import { Decision } from "../decide/decision";
import { statusText } from "../decide/findings";
import { Thumbnail } from "../decide/thumbnail";

const KINDS = ["integral", "thermal"] as const;

export function AlertedFinding() {
  const { state, alerts, mayJudge, notation } = useShell();
  const [closed, setClosed] = useState<ReadonlySet<number>>(new Set());
  const shownId = useRef<number | null>(null);
  const findings = state.mission?.findings ?? [];
  const shown = findings.find(({ finding_id: id }) => id === shownId.current && !closed.has(id)) ?? null;
  // Nothing else comes under the pointer while the operator has not decided.
  const finding = shown?.status === "new" ? shown : (undecidedAlerted(alerts, findings, closed) ?? shown);
  shownId.current = finding?.finding_id ?? null;
  if (!mayJudge || finding === null) return null;
  const { finding_id: id, operator } = finding;
  return (
    <section key={id} class="alerted-finding panel" aria-label={texts.decide.finding(id)} data-testid="alerted-finding">
      <div class="alerted-pictures">
        {KINDS.map((kind) => (
          <a
            key={kind}
            href={routeHash("decide", { finding: String(id) })}
            title={texts.alerts.showFinding(id)}
            tabIndex={-1}
          >
            <Thumbnail finding={finding} shot={{ kind, above_m: 0, isNearest: false }} />
          </a>
        ))}
      </div>
      <p>
        <b>{findingText(finding, notation)}</b> <Reasons finding={finding} />
      </p>
      <p class="small finding-status" data-testid="alerted-status" role="status">
        {statusText(finding)}
        {operator !== "" && ` · ${operator}`}
      </p>
      <div class="alerted-buttons">
        <Decision finding={finding} />
        <button
          type="button"
          data-testid="alerted-close"
          onClick={() => setClosed((before) => new Set([...before, id]))}
        >
          {texts.settings.close}
        </button>
      </div>
    </section>
  );
}

function Reasons({ finding: { reasons } }: { finding: Finding }) {
  if (reasons.length === 0) return null;
  return <span class="small">{reasons.map(said).join("; ")}</span>;
}
