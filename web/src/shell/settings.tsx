/** Settings of this screen: theme, alert sounds, notation, units and language, and the list of keyboard shortcuts. */
import { useState } from "preact/hooks";
import { type Notation, NOTATIONS } from "../coordinates";
import { lastState, offlinePageState } from "../offline/page";
import { isStorageWorking } from "../storage";
import { type Language, LANGUAGE_NAMES, LANGUAGES, texts } from "../texts";
import { type Theme, THEMES } from "../theme";
import { type Units, UNITS } from "../units";
import { Choice, type ChoiceProps } from "../ui/choice";
import { Dialog } from "../ui/dialog";
import { Accounts } from "./accounts";
import { signedInAs } from "./header";
import type { Access } from "./use_session";
import { type Voice, VOICES } from "./voice";

interface Props {
  access: Access;
  isSurvey: boolean;
  theme: Theme;
  onTheme(theme: Theme): void;
  voice: Voice;
  onVoice(voice: Voice): void;
  notation: Notation;
  onNotation(notation: Notation): void;
  units: Units;
  onUnits(units: Units): void;
  language: Language;
  /** Fails if the language cannot be loaded. */
  onLanguage(language: Language): Promise<void>;
  onClose(): void;
}

export function Settings({ access, isSurvey, theme, onTheme, voice, onVoice, ...props }: Props) {
  const { notation, onNotation, units, onUnits, language, onLanguage, onClose } = props;
  const [isLoaded, setLoaded] = useState(true);
  const { settings } = texts;
  return (
    <Dialog title={settings.open} testId="settings" onClose={onClose}>
      <Setting
        label={settings.theme}
        testId="theme"
        values={THEMES}
        chosen={theme}
        labels={settings.themes}
        onChoose={onTheme}
      />
      <Setting
        label={settings.alerts}
        testId="voice"
        values={VOICES}
        chosen={voice}
        labels={settings.voice}
        onChoose={onVoice}
      />
      <Setting
        label={settings.notation}
        testId="notation"
        values={NOTATIONS}
        chosen={notation}
        labels={texts.places.notation}
        onChoose={onNotation}
      />
      <Setting
        label={settings.units}
        testId="units"
        values={UNITS}
        chosen={units}
        labels={settings.unitNames}
        onChoose={onUnits}
      />
      <Setting
        label={settings.language}
        testId="language"
        values={LANGUAGES}
        chosen={language}
        labels={LANGUAGE_NAMES}
        onChoose={(chosen) => {
          onLanguage(chosen).then(
            () => setLoaded(true),
            () => setLoaded(false),
          );
        }}
      />
      {!isStorageWorking() && (
        <p class="is-warning" role="alert" data-testid="storage-problem">
          {settings.notStored}
        </p>
      )}
      <p class={lastState.keeping === "failed" ? "is-warning" : "small"} data-testid="offline-state">
        {lastState.keeping === "failed" ? texts.offline.notKept : texts.offline.page[offlinePageState()]}
      </p>
      {!isLoaded && (
        <p class="is-bad" role="alert" data-testid="language-problem">
          {settings.notLoaded}
        </p>
      )}
      {access.session?.accounts && access.session.role === "administrator" && <Accounts />}
      <h3>{texts.keys.title}</h3>
      <KeyList isSurvey={isSurvey} />
      <div class="dialog-buttons">
        {access.session !== null && access.session.sign_in_required && access.session.name !== "" && (
          <button type="button" data-testid="sign-out" onClick={() => void access.signOut()}>
            {texts.signIn.signOut} ({signedInAs(access.session)})
          </button>
        )}
        <button type="button" data-testid="settings-close" onClick={onClose}>
          {settings.close}
        </button>
      </div>
    </Dialog>
  );
}

/** Choice below its own title. */
function Setting<T extends string>(props: ChoiceProps<T>) {
  return (
    <>
      <h3>{props.label}</h3>
      <Choice {...props} />
    </>
  );
}

function KeyList({ isSurvey }: { isSurvey: boolean }) {
  const { keys } = texts;
  return (
    <dl class="key-list">
      {(isSurvey ? keys.ofSurvey : keys.list).map(([key, meaning]) => (
        <div key={key}>
          <dt>
            <kbd>{key}</kbd>
          </dt>
          <dd>{meaning}</dd>
        </div>
      ))}
    </dl>
  );
}
