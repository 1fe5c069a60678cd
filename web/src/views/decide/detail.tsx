/** Card of one finding: large images, where it is and which way, why it is believed, and the operators' decision. */
import { useState } from "preact/hooks";
import type { Finding } from "../../api/types";
import { eastNorth, likelihood } from "../../format";
import { useShell } from "../../shell/context";
import { said, texts } from "../../texts";
import { type Fact, Facts } from "../../ui/facts";
import { Panel } from "../../ui/panel";
import { Copy } from "./copy";
import { Decision, Remarks, RemarksForm } from "./decision";
import { ellipseText, notations, sightingsText, significanceText, statusText, timeText } from "./findings";
import { FindingPictures } from "./pictures";
import { Way } from "./reference";
import { SendOn } from "./send_on";
import type { Reference } from "./way";

interface Props {
  finding: Finding;
  reference: Reference;
  isSettingReference: boolean;
  onReference(place: Reference): void;
  onSetReferenceOnMap(): void;
  onClose(): void;
}

export function FindingDetail({ finding, onClose, ...ofReference }: Props) {
  const { mayJudge: mayDecide } = useShell();
  const [isSending, setSending] = useState(false);
  const { finding_id: id, operator } = finding;
  return (
    <Panel
      title={`${texts.decide.finding(id)}: ${texts.names.findingKind[finding.kind]}`}
      testId="finding-detail"
      class="finding-detail"
      aside={
        <>
          <span class={`badge finding-status is-${finding.status}`} data-testid="finding-status" role="status">
            {statusText(finding)}
            {operator !== "" && ` · ${operator}`}
          </span>
          <button type="button" data-testid="finding-close" onClick={onClose}>
            {texts.decide.close}
          </button>
        </>
      }
    >
      <div class="scroll finding-body" tabIndex={0} role="region" aria-label={texts.decide.finding(id)}>
        <Where key={`where ${id}`} finding={finding} {...ofReference} />
        <Why finding={finding} />
        <FindingPictures key={id} finding={finding} />
        {mayDecide ? <RemarksForm key={`remarks ${id}`} finding={finding} /> : <Remarks finding={finding} />}
        <OtherNotations finding={finding} />
      </div>
      <div class="finding-actions">
        {mayDecide && finding.merged_into === null && <Decision key={id} finding={finding} takesFocus />}
        <button type="button" data-testid="send-on" onClick={() => setSending(true)}>
          {texts.decide.sendOn}
        </button>
      </div>
      {isSending && <SendOn finding={finding} reference={ofReference.reference} onClose={() => setSending(false)} />}
    </Panel>
  );
}

type WhereProps = Omit<Props, "onClose">;

/** Position in the chosen notation with its error, and the way to it. */
function Where({ finding, reference, isSettingReference, onReference, onSetReferenceOnMap }: WhereProps) {
  const { notation } = useShell();
  const [first] = notations(finding, notation);
  return (
    <div class="where">
      {first && (
        <p class="position">
          <b data-testid={`position-${first[0]}`}>{first[1]}</b>
          <span data-testid="finding-error">{texts.decide.error(ellipseText(finding))}</span>
          <Copy text={first[1]} label={texts.decide.copyNotation(texts.places.notation[first[0]])} />
        </p>
      )}
      <Way
        finding={finding}
        reference={reference}
        isSetting={isSettingReference}
        onChange={onReference}
        onSetOnMap={onSetReferenceOnMap}
      />
    </div>
  );
}

/** How likely it is a person and why, and when it was seen. */
function Why({ finding }: { finding: Finding }) {
  const { mission } = useShell().state;
  const facts: Fact[] = [
    [texts.decide.confidence, likelihood(finding.person_confidence)],
    [texts.decide.significance, significanceText(finding)],
    [texts.decide.found, timeText(finding, finding.found_at_s, mission)],
    [texts.decide.seen, timeText(finding, finding.seen_at_s, mission)],
    [texts.decide.views, sightingsText(finding)],
  ];
  return (
    <div class="why">
      <Facts facts={facts} class="finding-facts" />
      <p class="small" data-testid="finding-reasons">
        {texts.decide.reasons}: {finding.reasons.length === 0 ? texts.noData : finding.reasons.map(said).join("; ")}
      </p>
    </div>
  );
}

/** Position in the notations that are not chosen, and from the origin. */
function OtherNotations({ finding }: { finding: Finding }) {
  const { notation } = useShell();
  const [, ...others] = notations(finding, notation);
  const { east_m, north_m } = finding.position;
  return (
    <details>
      <summary>{texts.decide.otherNotations}</summary>
      <ul class="notations">
        {others.map(([name, text]) => (
          <li key={name}>
            <span class="small">{texts.places.notation[name]}</span>
            <b data-testid={`position-${name}`}>{text}</b>
            <Copy text={text} label={texts.decide.copyNotation(texts.places.notation[name])} />
          </li>
        ))}
        <li>
          <span class="small">{texts.decide.local}</span>
          <b>{eastNorth(east_m, north_m)}</b>
        </li>
      </ul>
    </details>
  );
}
