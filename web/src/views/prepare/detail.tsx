/** Result of a check, what to do about it, and the form to override it. */
import { useState } from "preact/hooks";
import { overrideCheck } from "../../api/client";
import type { PreflightCheck } from "../../api/types";
import { useShell } from "../../shell/context";
import { said, texts } from "../../texts";
import { Panel } from "../../ui/panel";
import { nameOf, subjectOf } from "./checks";

export function CheckDetail({ check }: { check: PreflightCheck | undefined }) {
  if (check === undefined) {
    return (
      <Panel title={texts.prepare.detail} testId="check-detail">
        <p class="empty">{texts.prepare.choose}</p>
      </Panel>
    );
  }
  const title = `${subjectOf(check.vehicle_id)}: ${nameOf(check.name)}`;
  return (
    <Panel title={title} testId="check-detail" class="check-detail">
      <dl aria-live="polite">
        <dt>{texts.prepare.found}</dt>
        <dd>{said(check.text)}</dd>
        {check.remedy !== "" && (
          <>
            <dt>{texts.prepare.remedy}</dt>
            <dd data-testid="check-remedy">{said(check.remedy)}</dd>
          </>
        )}
        {check.overridden && (
          <>
            <dt>{texts.prepare.overriddenBy(check.overridden.by)}</dt>
            <dd data-testid="check-override">{check.overridden.reason}</dd>
          </>
        )}
      </dl>
      {check.status === "fail" && <OverrideForm key={title} check={check} />}
    </Panel>
  );
}

function OverrideForm({ check }: { check: PreflightCheck }) {
  const { state, mayCommand, isConnected } = useShell();
  const [reason, setReason] = useState("");
  const [refusal, setRefusal] = useState<string | null>(null);
  const isOffered = isConnected && state.mission?.allowed_actions.includes("override") === true;
  const send = async (given: string | null): Promise<void> => {
    const answer = await overrideCheck(check, given);
    setRefusal(answer.ok ? null : answer.message);
    if (answer.ok) setReason("");
  };
  if (!mayCommand) return null;
  if (!check.overridable) return <p class="small">{texts.prepare.notOverridable}</p>;
  return (
    <form
      class="form"
      onSubmit={(event) => {
        event.preventDefault();
        void send(reason.trim());
      }}
    >
      {check.overridden ? (
        <button type="button" data-testid="override-back" disabled={!isOffered} onClick={() => void send(null)}>
          {texts.prepare.takeBack}
        </button>
      ) : (
        <>
          <label>
            {texts.prepare.reason}
            <textarea
              rows={2}
              required
              maxLength={500}
              data-testid="override-reason"
              value={reason}
              onInput={(event) => setReason(event.currentTarget.value)}
            />
          </label>
          <button type="submit" data-testid="override-ok" disabled={!isOffered || reason.trim() === ""}>
            {texts.prepare.override}
          </button>
        </>
      )}
      <p class="is-bad" role="alert" data-testid="override-refusal">
        {refusal}
      </p>
    </form>
  );
}
