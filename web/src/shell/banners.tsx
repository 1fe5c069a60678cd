/**
 * Banners for a page whose data are out of date, incomplete, or of another mission.
 *
 * They share one place: the most urgent one comes first and hides the others until it is gone.
 */
import { useState } from "preact/hooks";
import type { Connection } from "../api/socket";
import { age, dateAndTime } from "../format";
import { texts } from "../texts";

interface Props {
  connection: Connection;
  /** Whether a survey is shown, which has neither vehicles nor pilots. */
  isSurvey: boolean;
  /** Seconds since the last update of a mission that does not respond; null if it responds. */
  silence_s: number | null;
  /** Clock time at which a state of an earlier visit was valid; null for one of the station. */
  keptAtMs: number | null;
  /** Seconds since the shown state was valid. */
  snapshotAge_s: number;
  /** Whether the station has another page than this one. */
  hasOtherPage: boolean;
  missedNotices: number;
  /** Null before the station has sent it. */
  missionId: string | null;
  /** Mission that this page showed before; null if there was none. */
  formerMissionId: string | null;
  /** Whether the sign-in of this operator has expired. */
  isSignInExpired: boolean;
  onSignIn(): void;
}

export function Banners(props: Props) {
  const { connection, isSurvey, silence_s, keptAtMs, snapshotAge_s, hasOtherPage, missedNotices } = props;
  const { missionId, formerMissionId, isSignInExpired, onSignIn } = props;
  const lost = isSurvey ? texts.connection.lostSurveyBanner : texts.connection.lostBanner;
  return (
    <>
      {connection !== "open" && keptAtMs !== null && <Kept keptAtMs={keptAtMs} age_s={snapshotAge_s} />}
      {((connection === "lost" && keptAtMs === null) || connection === "incompatible") && (
        <p class="banner" role="alert" data-testid="banner">
          {connection === "lost" ? lost : texts.connection.incompatibleBanner}
        </p>
      )}
      {connection === "open" && silence_s !== null && (
        <p class="banner" data-testid="silent-banner">
          {/* Announced once: seconds that count would repeat themselves. */}
          <span role="alert">
            {isSurvey ? texts.connection.silentSurveyBanner : texts.connection.silentBanner}
          </span>{" "}
          {texts.connection.silentFor(age(silence_s))}
        </p>
      )}
      {connection === "open" && hasOtherPage && (
        <div class="banner" data-testid="other-page">
          <span role="alert">{texts.offline.otherPage}</span>{" "}
          <button type="button" data-testid="reload" onClick={() => location.reload()}>
            {texts.offline.reload}
          </button>
        </div>
      )}
      {connection === "open" && isSignInExpired && (
        <div class="banner" data-testid="signed-out">
          <span role="alert">{texts.signIn.expired}</span>{" "}
          <button type="button" data-testid="sign-in-again" onClick={onSignIn}>
            {texts.signIn.open}
          </button>
        </div>
      )}
      {missionId !== null && formerMissionId !== null && <AnotherMission id={missionId} formerId={formerMissionId} />}
      <Missed count={missedNotices} />
    </>
  );
}

/** Banner of a page that was opened without the station: what it shows is over, and it says since when. */
function Kept({ keptAtMs, age_s }: { keptAtMs: number; age_s: number }) {
  const { offline } = texts;
  return (
    <p class="banner" data-testid="kept-banner">
      <span role="alert">{offline.lastState(dateAndTime(keptAtMs / 1000))}</span>{" "}
      <b data-testid="kept-age">{Number.isFinite(age_s) ? offline.age(age(age_s)) : offline.ageUnknown}</b>{" "}
      {offline.noCommands}
    </p>
  );
}

function Missed({ count }: { count: number }) {
  const [read, setRead] = useState(0);
  if (count <= read) return null;
  return (
    <div class="banner" data-testid="missed-banner">
      <span role="alert">{texts.connection.missed(count)}</span>{" "}
      <button type="button" data-testid="missed-dismiss" onClick={() => setRead(count)}>
        {texts.actions.dismiss}
      </button>
    </div>
  );
}

function AnotherMission({ id, formerId }: { id: string; formerId: string }) {
  const [readId, setReadId] = useState<string | null>(null);
  if (id === readId) return null;
  return (
    <div class="banner" data-testid="another-mission">
      <span role="alert">{texts.connection.anotherMission(id, formerId)}</span>{" "}
      <button type="button" data-testid="another-mission-dismiss" onClick={() => setReadId(id)}>
        {texts.actions.dismiss}
      </button>
    </div>
  );
}
