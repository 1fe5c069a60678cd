/** German texts of the view Fly. */
import type { Texts } from "../../texts";
import { plural } from "./plural";

export const heights: Texts["heights"] = {
  agl: "AGL",
  home: "rel.",
  aboveGround: "über Grund",
  aboveHome: "über dem Startpunkt",
  aboveSea: "über dem Meer",
};

export const fleet: Texts["fleet"] = {
  panel: "Flotte",
  none: "Noch keine Drohne verbunden.",
  nonePass: "Keine Drohne entspricht diesem Filter.",
  filter: "Zeigen",
  filters: { all: "Alle", attention: "Achtung", airborne: "In der Luft", battery: "Akku schwach" },
  view: "Ansicht",
  viewTitle: "Ansicht der Flotte auf diesem Bildschirm",
  layout: "Anordnung",
  layouts: { tiles: "Kacheln", table: "Tabelle" },
  order: "Reihenfolge",
  orders: { worst: "Dringendste zuerst", number: "Nach Nummer" },
  columnsTitle: "Spalten der Tabelle",
  select: "Auswählen",
  id: "Nr.",
  columns: {
    mode: "Modus",
    task: "Aufgabe",
    armed: "Motoren",
    battery: "Akku",
    gps: "GPS",
    link: "Funk",
    height: "Höhe",
    message: "Meldung",
  },
  armed: "scharf",
  disarmed: "gesichert",
  neverHeard: "kein Kontakt",
  linkHint: "Alter der letzten Meldung, Paketverlust, Antwortzeit",
  selectRow: (id) => `Drohne ${id} auswählen`,
};

export const attention: Texts["attention"] = {
  neverHeard: "noch kein Kontakt",
  silent: (age) => `kein Kontakt seit ${age}`,
  fix: (fix) => `GPS: ${fix}`,
  battery: (percent) => `Akku ${percent}`,
  loss: (percent) => `Verlust ${percent}`,
  camera: (reason) => `kein Bild: ${reason}`,
};

export const vehicle: Texts["vehicle"] = {
  panel: (id) => `Drohne ${id}`,
  close: "Schließen",
  toFrames: "Bilder aller Drohnen",
  frame: (kind, id, step) => `${kind}: Bild von Drohne ${id}, Schritt ${step}`,
  caption: (kind, step) => `${kind}, Schritt ${step}`,
  roundTrip: "Antwortzeit",
  speed: "Geschwindigkeit über Grund",
  away: "Vom Startpunkt",
  frames: "Bilder",
  framesOf: (frames, missing) => `${frames}, ${missing} fehlen`,
  heading: "Kurs",
};

export const relay: Texts["relay"] = {
  panel: "Akkuwechsel",
  next: (id) => `Als Nächste: Drohne ${id}`,
  leavesIn: (time) => `noch ${time}`,
  due: "jetzt",
  ready: "bereit zum Start",
  unconfirmed: "am Boden: Bereitschaft nicht bestätigt",
};

export const target: Texts["target"] = {
  panel: "Ziele",
  none: "Noch keine Ziele.",
  sightings: (count) => plural(count, "Sichtung", "Sichtungen"),
  error: (sigma) => `± ${sigma} (1 σ)`,
  taken: (kind, probability) => `${kind} (Person: ${probability})`,
  later: "Wird später genauer betrachtet",
  person: (probability) => `Person: ${probability}`,
};
