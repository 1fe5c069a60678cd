/** German translations of what the station says of live sharing, and of surveys of recorded flights. */
import type { StationText } from "../../station";

export const sharing: readonly StationText[] = [
  ["Sharing with {name} ({target}): {text}", "Weitergabe an {name} ({target}): {text}"],
  [
    "Sharing with {name} ({target}): nothing is shared. {text}",
    "Weitergabe an {name} ({target}): Nichts wird weitergegeben. {text}",
  ],
  ["From {source}: {what} for the plan", "Von {source}: {what} für den Plan"],
  ["one proposal waits", "ein Vorschlag wartet"],
  ["{count} proposals wait", "{count} Vorschläge warten"],
  [
    "{program}'s process {reason} and is replaced. The mission goes on",
    "Prozess „{program}“ {reason} und wird ersetzt. Die Mission geht weiter",
  ],
  // Surveys.
  ["{count} of {all} pictures examined: {found}.", "{count} von {all} Bildern untersucht: {found}."],
  ["{count} of {all} pictures examined: {found}", "{count} von {all} Bildern untersucht: {found}"],
  [
    "{share} % of the photographed ground has no height in {file}: not examined",
    "{share} % des fotografierten Bodens haben keine Höhe in {file}: nicht untersucht",
  ],
  ["{count} possible person", "{count} mögliche Person"],
  ["{count} possible persons", "{count} mögliche Personen"],
  ["no person found", "keine Person gefunden"],
  [
    "{found}, as no place is in {views} successive pictures: only pictures that overlap can be examined",
    "{found}, da kein Ort auf {views} aufeinanderfolgenden Bildern ist: Nur Bilder, die sich überlappen, können untersucht werden",
  ],
  [
    "{found}, as no place with a height is in {views} successive pictures: only pictures that overlap can be examined",
    "{found}, da kein Ort mit bekannter Höhe auf {views} aufeinanderfolgenden Bildern ist: Nur Bilder, die sich überlappen, können untersucht werden",
  ],
  [
    "{found}, in the {share} % of the ground with a height that {views} successive pictures or more show",
    "{found}, auf den {share} % des Bodens mit bekannter Höhe, die {views} aufeinanderfolgende Bilder oder mehr zeigen",
  ],
  [
    "{found}, in the {share} % of the ground that {views} successive pictures or more show",
    "{found}, auf den {share} % des Bodens, die {views} aufeinanderfolgende Bilder oder mehr zeigen",
  ],
  ["Finding {id}: possible person", "Fund {id}: mögliche Person"],
  ["Finding {id}: anomaly", "Fund {id}: Anomalie"],
  ["Picture left out: {reason}", "Bild ausgelassen: {reason}"],
  ["Picture {name} left out: {reason}", "Bild {name} ausgelassen: {reason}"],
  ["A window is left out: {reason}", "Ein Fenster ist ausgelassen: {reason}"],
  ["None of the {count} images can be read: {reason}", "Keines der {count} Bilder ist lesbar: {reason}"],
  [
    "The pictures see ground over {width} km, more than {limit} km: check the height of the ground and the field of view, and put each flight into a folder of its own, or choose its pictures with --frames.",
    "Die Bilder zeigen Boden über {width} km, mehr als {limit} km: Höhe des Bodens und Sichtfeld prüfen und jeden Flug in einen eigenen Ordner legen oder seine Bilder mit --frames wählen.",
  ],
  [
    "No image was taken above the terrain: check that both are in the same world.",
    "Kein Bild wurde über dem Gelände aufgenommen: prüfen, ob beide dasselbe Koordinatensystem haben.",
  ],
];
