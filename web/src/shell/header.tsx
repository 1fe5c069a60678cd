/** Top bar: state of the mission, whether it is live, and the button that holds all vehicles. */
import type { ComponentChildren } from "preact";
import type { Connection } from "../api/socket";
import type { Mission, Session } from "../api/types";
import { duration, quantity } from "../format";
import { may } from "../state/roles";
import { said, texts } from "../texts";
import "./accounts.css";
import { ControlButton } from "./control";
import { HoldAll } from "./hold_all";
import { NameField } from "./name_field";
import type { AskedName } from "./use_asked_name";

interface Props {
  mission: Mission | null;
  /** State `silent`: the station answers, but the mission does not. */
  connection: Connection | "silent";
  session: Session | null;
  /** Name that is asked for in the place of the button that opens the sign-in. */
  asked: AskedName | null;
  mayCommand: boolean;
  isSurvey: boolean;
  onHoldAll(): void;
  onSignIn(): void;
  onSettings(): void;
  /** Banners; while there is one, it takes the place of the mission's message, so that nothing below moves. */
  children: ComponentChildren;
}

export function Header(props: Props) {
  const { mission, connection, session, asked, mayCommand, isSurvey, onHoldAll, onSignIn, onSettings, children } =
    props;
  const isNamed = session !== null && session.name !== "";
  const isObserver = session !== null && !may(session.role, "operator");
  return (
    <header class="header">
      <h1>{texts.title}</h1>
      {mission && <Facts mission={mission} isSurvey={isSurvey} />}
      <div class="words">
        {children}
        <p class="message" data-testid="message" role="status" title={mission ? said(mission.message) : undefined}>
          {mission ? said(mission.message) : texts.waiting}
        </p>
      </div>
      <span class={`connection is-${connection}`} data-testid="connection" data-state={connection} role="status">
        {texts.connection[connection]}
        {isNamed && (
          <small>
            <b data-testid="operator" title={signedInAs(session)}>
              {session.name}
            </b>{" "}
            {session.sign_in_required && (
              <button type="button" class="not-me" data-testid="not-me" onClick={onSignIn}>
                {texts.signIn.notMe}
              </button>
            )}
          </small>
        )}
        {isObserver && (
          <small class="badge" data-testid={session.role}>
            {texts.team.roles[session.role]}
          </small>
        )}
      </span>
      {session !== null && may(session.role, "operator") && (
        <ControlButton control={mission?.control ?? null} own={session.name} />
      )}
      <button type="button" data-testid="settings-open" onClick={onSettings}>
        {texts.settings.open}
      </button>
      {mayCommand && <HoldAll testId="hold-all" onHoldAll={onHoldAll} />}
      {asked !== null && <NameField asked={asked} onSignIn={onSignIn} />}
      {asked === null && session !== null && session.sign_in_required && !isNamed && (
        <button
          type="button"
          data-testid="sign-in-open"
          title={session.accounts ? undefined : texts.header.observerHint}
          onClick={onSignIn}
        >
          {texts.signIn.open}
        </button>
      )}
    </header>
  );
}

/** Text about who has signed in; roles only where there are several for a name. */
export function signedInAs({ name, role, accounts }: Session): string {
  return accounts ? texts.team.account.signedInAs(name, texts.team.roles[role]) : texts.signIn.signedInAs(name);
}

function Facts({ mission, isSurvey }: { mission: Mission; isSurvey: boolean }) {
  const { header } = texts;
  const isSuspended = mission.suspension !== "none";
  return (
    <dl class="facts">
      <div class="phase">
        <dt>{header.phase}</dt>
        <dd aria-live="polite">
          <span data-testid="phase">
            {isSurvey ? texts.survey.phase(mission.phase === "done") : texts.names.phase[mission.phase]}
          </span>
          {isSuspended && <em data-testid="suspension">{texts.names.suspension[mission.suspension]}</em>}
        </dd>
      </div>
      <Fact name={header.elapsed} value={duration(mission.elapsed_s)} testId="elapsed" />
      {mission.outcome !== "open" && (
        <Fact name={header.outcome} value={texts.names.outcome[mission.outcome]} testId="outcome" />
      )}
      <Fact name={isSurvey ? texts.survey.window : header.step} value={String(mission.step)} testId="step" />
      {!isSurvey && (
        <Fact name={header.separation} value={quantity(mission.min_separation_m, 1, "m")} testId="separation" />
      )}
    </dl>
  );
}

function Fact({ name, value, testId }: { name: string; value: string; testId: string }) {
  return (
    <div class={`fact-${testId}`}>
      <dt>{name}</dt>
      <dd data-testid={testId}>{value}</dd>
    </div>
  );
}
