/** German translations of what is wrong with records, plans on the disk, and the map of searched ground. */
import type { StationText } from "../../station";

export const records: readonly StationText[] = [
  [
    "A plan named '{name}' already exists. Choose another name, or replace it.",
    "Einen Plan namens „{name}“ gibt es schon. Einen anderen Namen wählen oder ihn ersetzen.",
  ],
  [
    "The plan '{name}' was removed by another operator in the meantime. Review it, or save again.",
    "Der Plan „{name}“ wurde inzwischen von jemand anderem gelöscht. Prüfen oder noch einmal speichern.",
  ],
  [
    "The plan '{name}' was saved by another operator in the meantime. Review it, or save again.",
    "Der Plan „{name}“ wurde inzwischen von jemand anderem gespeichert. Prüfen oder noch einmal speichern.",
  ],
  [
    "The plan cannot be saved as {file}: {reason}; free some space or check the disk.",
    "Der Plan kann nicht als {file} gespeichert werden: {reason}; Platz schaffen oder den Datenträger prüfen.",
  ],
  ["{folder} has no event {number}", "{folder} hat kein Ereignis {number}"],
  ["{folder} has no frame {number}", "{folder} hat kein Bild {number}"],
  ["{folder} has no step {number}", "{folder} hat keinen Schritt {number}"],
  ["{file} is damaged: {reason}", "{file} ist beschädigt: {reason}"],
  [
    "{folder} is not a mission folder: it contains no {file}",
    "{folder} ist kein Missionsordner: Er enthält kein {file}",
  ],
  ["{file} is damaged or not a mission: {reason}", "{file} ist beschädigt oder keine Mission: {reason}"],
  [
    "{folder} cannot be opened in place ({reason}); copy the mission's folder and try there",
    "{folder} kann hier nicht geöffnet werden ({reason}); den Missionsordner kopieren und dort versuchen",
  ],
  ["cannot read the frame {number}: {reason}", "Bild {number} kann nicht gelesen werden: {reason}"],
  ["a {kind} image is damaged: {reason}", "ein Bild ({kind}) ist beschädigt: {reason}"],
  [
    "{folder} exists already; choose another name or folder",
    "{folder} gibt es schon; einen anderen Namen oder Ordner wählen",
  ],
  [
    "cannot record into {folder}: {reason}; free some space or check the disk",
    "in {folder} kann nicht aufgezeichnet werden: {reason}; Platz schaffen oder den Datenträger prüfen",
  ],
  [
    "the folder {folder} cannot be made: {reason}; check its path and rights, and the space on the disk",
    "der Ordner {folder} kann nicht angelegt werden: {reason}; Pfad, Rechte und freien Platz prüfen",
  ],
  [
    "the mission id {id} is not a valid folder name; use letters, digits, - and _",
    "die Missionskennung {id} ist kein gültiger Ordnername; Buchstaben, Ziffern, - und _ verwenden",
  ],
  [
    "the record in {folder} cannot be continued: {reason}",
    "die Aufzeichnung in {folder} kann nicht fortgesetzt werden: {reason}",
  ],
  [
    "it was set back, but that cannot be noted in {file}: {reason}",
    "sie wurde zurückgesetzt, aber das kann nicht in {file} vermerkt werden: {reason}",
  ],
  ["{folder} holds no survey.", "{folder} enthält keine Auswertung."],
  ["Cannot write {file}: {reason}.", "{file} kann nicht geschrieben werden: {reason}."],
  ["{file} cannot be read: it is not a file.", "{file} kann nicht gelesen werden: Das ist keine Datei."],
  [
    "{file} is a file; name the folder that holds the images.",
    "{file} ist eine Datei; den Ordner mit den Bildern nennen.",
  ],
  ["{file} cannot be read: {reason}", "{file} kann nicht gelesen werden: {reason}"],
  // The map of searched ground.
  [
    "The map of searched ground cannot be written to {folder}: {reason}.",
    "Die Karte des abgesuchten Bodens kann nicht in {folder} geschrieben werden: {reason}.",
  ],
  [
    "{file} is not the head of a map of searched ground, or is damaged: {reason}",
    "{file} ist nicht der Kopf einer Karte des abgesuchten Bodens oder ist beschädigt: {reason}",
  ],
  [
    "{file}: direction_step must be positive, got {value}.",
    "{file}: direction_step muss positiv sein, ist aber {value}.",
  ],
  [
    "{file}: format {format} is unknown; this version reads {readable}.",
    "{file}: Das Format {format} ist unbekannt; diese Version liest {readable}.",
  ],
  [
    "{file}: the map of searched ground belongs to another origin.",
    "{file}: Die Karte des abgesuchten Bodens gehört zu einem anderen Ursprung.",
  ],
  [
    "{file} is not a tile of the searched ground, or is damaged: {reason}",
    "{file} ist keine Kachel des abgesuchten Bodens oder ist beschädigt: {reason}",
  ],
  [
    "{file}: {name} has shape {shape} and type {type}, but {wanted_shape} and {wanted_type} are expected.",
    "{file}: {name} hat die Form {shape} und den Typ {type}, erwartet sind {wanted_shape} und {wanted_type}.",
  ],
];
