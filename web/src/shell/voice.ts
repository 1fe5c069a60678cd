/** Sounds of alerts: tones and the speech of the browser. Nothing leaves the machine. */
import type { Severity } from "../api/types";
import { readStored, store } from "../storage";
import { chosenLanguage } from "../texts";

export const VOICES = ["off", "sound", "speech"] as const;
export type Voice = (typeof VOICES)[number];

const KEY = "aos-gcs-voice";
const TONE_S = 0.16;
const GAP_S = 0.08;
/** Frequencies in hertz, one per tone. */
const TONES: Readonly<Record<Severity, readonly number[]>> = {
  info: [],
  warning: [660],
  news: [523, 659, 784],
  critical: [880, 660, 880],
};

export function storedVoice(): Voice {
  return VOICES.find((voice) => voice === readStored(KEY)) ?? "sound";
}

export function storeVoice(voice: Voice): void {
  store(KEY, voice);
}

let audio: AudioContext | null = null;

/** Sound an alert. Browsers are silent until the page was clicked or touched once. */
export function announce(voice: Voice, severity: Severity, text: string): void {
  if (voice === "off" || !navigator.userActivation.hasBeenActive) return;
  audio ??= new AudioContext();
  playTones(audio, TONES[severity]);
  if (voice === "speech" && "speechSynthesis" in window) {
    if (severity === "critical") speechSynthesis.cancel();
    const utterance = new SpeechSynthesisUtterance(text);
    // The voice must be of the language of the words.
    utterance.lang = chosenLanguage();
    speechSynthesis.speak(utterance);
  }
}

function playTones(context: AudioContext, frequencies_hz: readonly number[]): void {
  frequencies_hz.forEach((frequency_hz, index) => {
    const start_s = context.currentTime + index * (TONE_S + GAP_S);
    const tone = new OscillatorNode(context, { frequency: frequency_hz });
    const volume = new GainNode(context, { gain: 0.2 });
    tone.connect(volume).connect(context.destination);
    tone.start(start_s);
    tone.stop(start_s + TONE_S);
  });
}
