/** Shell: header, tabs, alerts and windows around one view. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { HoldStream } from "../api/hold";
import { storedNotation, storeNotation } from "../coordinates";
import { useOffline } from "../offline/use_offline";
import { ReplayBar } from "../replay/bar";
import { alertedFinding } from "../state/findings";
import { isSilent } from "../state/freshness";
import { BEFORE_START } from "../state/commands";
import { may } from "../state/roles";
import { NO_SELECTION, retain, select, typeDigit } from "../state/selection";
import type { Store } from "../state/store";
import { chooseLanguage, chosenLanguage, storeLanguage, texts } from "../texts";
import { useTheme } from "../theme";
import { chooseUnits, storedUnits, storeUnits } from "../units";
import { DialogCorner } from "../ui/dialog";
import { AlertBar } from "./alert_bar";
import { Banners } from "./banners";
import { Boundary } from "./boundary";
import { useCommands } from "./commands";
import { type Shell, ShellContext } from "./context";
import { Header } from "./header";
import { HoldAll } from "./hold_all";
import { useKeys, useRoute, useStoreState } from "./hooks";
import type { KeyCommand } from "./keys";
import { LoadedView } from "./loaded_view";
import { Nav } from "./nav";
import { Question } from "./question";
import { isViewOfSurveys, openUnnamed, routeHash } from "./route";
import { Settings } from "./settings";
import { SignIn } from "./sign_in";
import { Toast } from "./toast";
import { useAlerts } from "./use_alerts";
import { useAskedName } from "./use_asked_name";
import { useSession } from "./use_session";
import { storedVoice, storeVoice } from "./voice";

export function App({ store, stream }: { store: Store; stream: HoldStream }) {
  const state = useStoreState(store);
  const access = useSession(state.connection, () => stream.renew());
  const hasOtherPage = useOffline(store, state, access.session);
  const route = useRoute(state.capabilities.survey);
  const [theme, setTheme] = useTheme();
  const [voice, setVoice] = useState(storedVoice);
  const [notation, setNotation] = useState(storedNotation);
  const [units, setUnits] = useState(storedUnits);
  chooseUnits(units);
  const [language, setLanguage] = useState(chosenLanguage);
  const asked = useAskedName(access);
  const [isSigningIn, setSigningIn] = useState(access.invitation !== "");
  useEffect(() => {
    // Who has used this screen last opens the address of operators: their name is known, and shown.
    if (access.code === "" || access.lastName === "") return;
    void access.signInAgain().then((refusal) => refusal !== null && setSigningIn(true));
  }, []);
  const [areSettingsOpen, setSettingsOpen] = useState(false);
  const [selection, changeSelection] = useState(NO_SELECTION);
  const { mission, connection } = state;
  const navigate: Shell["navigate"] = (view, params) => (location.hash = routeHash(view, params));
  const main = useRef<HTMLElement>(null);
  /** Go to a view other than by its tab: the next press of Tab leads into it, not through the top of the page again. */
  const enter: Shell["navigate"] = (view, params) => {
    main.current?.focus({ preventScroll: true });
    navigate(view, params);
  };
  const commands = useCommands({
    mission,
    selection,
    isConnected: connection === "open",
    stream,
    onForbidden: access.refresh,
    onNewSortie: () => enter("prepare"),
    onLaunched: () => route.view === "prepare" && enter("fly"),
  });
  const fleet = mission?.vehicles.map((vehicle) => vehicle.vehicle_id) ?? [];
  useEffect(() => changeSelection((before) => retain(before, fleet)), [fleet.join()]);

  // While the role is unknown the page offers commands and the station decides: a hold must not wait for an answer.
  const role = access.session?.role ?? "operator";
  const isOperator = access.session !== null && may(role, "operator");
  const isToPrepare = isOperator || asked !== null;
  const isReplay = mission !== null && mission.replay !== null;
  const isSurvey = state.capabilities.survey;
  const mayCommand = may(role, "operator") && !isReplay && !isSurvey;
  useEffect(() => {
    // Before the launch an operator who has opened no view in particular prepares it.
    if (isToPrepare && mission !== null && !isReplay && !isSurvey && BEFORE_START.has(mission.phase))
      openUnnamed("prepare");
  }, [isToPrepare, mission === null]);
  // Ages in a recording are those of its own time, even while it is paused.
  const snapshotAge_s = isReplay ? 0 : (performance.now() - state.missionAtMs) / 1000;
  const isMissionSilent = connection === "open" && isSilent(mission, snapshotAge_s);
  const alerts = useAlerts(state, isMissionSilent, voice);
  const shell: Shell = {
    state,
    snapshotAge_s,
    isConnected: connection === "open",
    isOperator,
    mayCommand,
    operator: access.session?.name ?? "",
    asked: isSurvey || isReplay ? null : asked,
    alerts,
    mayJudge: may(role, "analyst") && !isReplay && state.capabilities.findings,
    mayMakeVideos: may(role, "analyst") && state.capabilities.video,
    isSurvey,
    theme,
    notation,
    route,
    navigate,
    selection,
    changeSelection,
    commands,
  };
  const execute = (command: KeyCommand): void => {
    if (command.kind === "holdAll") {
      // Observers read the refusal of the station: a key without any effect could look as if it had worked.
      if (!isReplay && !isSurvey) commands.holdAll();
    } else if (command.kind === "view") {
      if (!isSurvey || isViewOfSurveys(command.view)) enter(command.view);
    } else if (command.kind === "showFinding") {
      const finding = alertedFinding(alerts, mission?.findings ?? []);
      if (finding !== null) enter("decide", { finding: String(finding.finding_id) });
    } else if (command.kind === "digit")
      changeSelection((before) => typeDigit(before, command, fleet, performance.now()));
    else if (command.kind === "help") setSettingsOpen(true);
    else changeSelection((before) => select(before, command.kind === "selectAll" ? fleet : []));
  };
  useKeys(execute);

  return (
    <ShellContext.Provider value={shell}>
      <DialogCorner.Provider value={mayCommand && <HoldAll testId="dialog-hold-all" onHoldAll={commands.holdAll} />}>
        <div class={`page ${connection === "open" && !isMissionSilent ? "" : "is-old"}`}>
          <Header
            mission={mission}
            connection={isMissionSilent ? "silent" : connection}
            session={access.session}
            asked={isSigningIn ? null : asked}
            mayCommand={mayCommand}
            isSurvey={isSurvey}
            onHoldAll={commands.holdAll}
            onSignIn={() => setSigningIn(true)}
            onSettings={() => setSettingsOpen(true)}
          >
            <Banners
              isSurvey={isSurvey}
              connection={connection}
              silence_s={isMissionSilent ? snapshotAge_s : null}
              keptAtMs={state.keptAtMs}
              snapshotAge_s={snapshotAge_s}
              hasOtherPage={hasOtherPage}
              missedNotices={state.missedNotices}
              missionId={mission?.mission_id ?? null}
              formerMissionId={mission?.replay ? null : state.formerMissionId}
              isSignInExpired={access.isExpired}
              onSignIn={() => setSigningIn(true)}
            />
          </Header>
          <div class="nav-row">
            <Nav current={route.view} isSurvey={isSurvey} />
            <AlertBar alerts={alerts} mayAcknowledge={mayCommand} />
          </div>
          {mission?.replay && (
            <ReplayBar replay={mission.replay} missionId={mission.mission_id} mayControl={isOperator} />
          )}
          {/* With other units, or in another language, everything is written anew. */}
          <main
            key={`${units} ${language}`}
            ref={main}
            class={`view view-${route.view}`}
            tabIndex={-1}
            aria-label={texts.nav.view[route.view]}
          >
            <Boundary key={`${route.view} ${mission?.mission_id ?? ""}`}>
              <LoadedView name={route.view} />
            </Boundary>
          </main>
          {(route.view !== "fly" || !mayCommand) && <Toast commands={commands} />}
          <Question commands={commands} />
          {(isSigningIn || role === "visitor") && (
            <SignIn access={access} typedName={asked?.name ?? ""} onClose={() => setSigningIn(false)} />
          )}
          {areSettingsOpen && (
            <Settings
              access={access}
              isSurvey={isSurvey}
              theme={theme}
              onTheme={setTheme}
              voice={voice}
              onVoice={(chosen) => {
                storeVoice(chosen);
                setVoice(chosen);
              }}
              notation={notation}
              onNotation={(chosen) => {
                storeNotation(chosen);
                setNotation(chosen);
              }}
              units={units}
              onUnits={(chosen) => {
                storeUnits(chosen);
                setUnits(chosen);
              }}
              language={language}
              onLanguage={async (chosen) => {
                await chooseLanguage(chosen);
                storeLanguage(chosen);
                setLanguage(chosen);
              }}
              onClose={() => setSettingsOpen(false)}
            />
          )}
        </div>
      </DialogCorner.Provider>
    </ShellContext.Provider>
  );
}
