/** German translations of what the station answers to requests: sign-in, accounts, control, files, what is not there. */
import type { StationText } from "../../station";

export const access: readonly StationText[] = [
  // Sign-in and accounts.
  [
    "'{name}' is the last administrator. Make another one first.",
    "„{name}“ ist der letzte Administrator. Zuerst einen anderen ernennen.",
  ],
  [
    "{file} is no file of accounts ({problem}). Restore it from a copy, or remove it and add the accounts anew with aos-gcs accounts.",
    "{file} ist keine Datei mit Konten ({problem}). Aus einer Kopie wiederherstellen, oder entfernen und die Konten mit aos-gcs accounts neu anlegen.",
  ],
  ["The accounts cannot be changed in {file}: {error}.", "Die Konten in {file} können nicht geändert werden: {error}."],
  ["The accounts cannot be read from {file}: {error}.", "Die Konten können nicht aus {file} gelesen werden: {error}."],
  [
    "There are {count} accounts, the largest number. Remove some first.",
    "Es gibt {count} Konten, mehr sind nicht möglich. Zuerst einige entfernen.",
  ],
  [
    "There are {count} open invitations; wait until some have expired.",
    "Es gibt {count} offene Einladungen; warten, bis einige abgelaufen sind.",
  ],
  [
    "There is an account '{name}' already. Take another name, or remove it first.",
    "Ein Konto „{name}“ gibt es schon. Einen anderen Namen nehmen oder es zuerst entfernen.",
  ],
  ["There is no account '{name}'.", "Es gibt kein Konto „{name}“."],
  [
    "This invitation is unknown, was used, or has expired. Ask for a new one.",
    "Diese Einladung ist unbekannt, verwendet oder abgelaufen. Um eine neue bitten.",
  ],
  [
    "name: 1 to {most} characters, without a slash, and no blanks around it.",
    "Name: 1 bis {most} Zeichen, ohne Schrägstrich und ohne Leerzeichen am Rand.",
  ],
  ["role: observer, analyst, operator or administrator.", "Rolle: Beobachter, Auswerter, Bediener oder Administrator."],
  [
    "password: between {least} and {most} characters; several words are best.",
    "Passwort: zwischen {least} und {most} Zeichen; am besten mehrere Wörter.",
  ],
  ["password: too easy to guess; several words are best.", "Passwort: zu leicht zu erraten; am besten mehrere Wörter."],
  ["password: missing; sign in with an account.", "Passwort fehlt; mit einem Konto anmelden."],
  ["code: missing; this service has no accounts.", "Code fehlt; dieser Dienst hat keine Konten."],
  [
    "This needs the role {needed}; you are signed in as {role}. Ask an administrator.",
    "Dafür braucht es die Rolle {needed}; angemeldet als {role}. Einen Administrator fragen.",
  ],
  ["observer", "Beobachter"],
  ["analyst", "Auswerter"],
  ["administrator", "Administrator"],
  [
    "This service has no accounts. Sign in with the operator code.",
    "Dieser Dienst hat keine Konten. Mit dem Bedienercode anmelden.",
  ],
  [
    "This service has no accounts; see api.accounts in docs/configuration.md.",
    "Dieser Dienst hat keine Konten; siehe api.accounts in docs/configuration.md.",
  ],
  ["Too many wrong codes. Wait {wait} s, then {remedy}.", "Zu viele falsche Codes. {wait} s warten, dann: {remedy}."],
  [
    "Too many wrong passwords. Wait {wait} s, then {remedy}.",
    "Zu viele falsche Passwörter. {wait} s warten, dann: {remedy}.",
  ],
  [
    "sign in with the code that the service printed when it started",
    "mit dem Code anmelden, den der Dienst beim Start ausgegeben hat",
  ],
  ["sign in again", "erneut anmelden"],
  ["Wrong name or password.", "Name oder Passwort falsch."],
  [
    "The operator code cannot be read from {file}: {error}.",
    "Der Bedienercode kann nicht aus {file} gelesen werden: {error}.",
  ],
  [
    "The operator code in {file} must have {least} or more characters, but has {count}.",
    "Der Bedienercode in {file} muss {least} oder mehr Zeichen haben, hat aber {count}.",
  ],
  // Control.
  ["operator: {name} does not ask for control now.", "{name} bittet jetzt nicht um die Steuerung."],
  [
    "reason: say in a few words why you take over control from {name}.",
    "Begründung: in wenigen Worten sagen, warum die Steuerung von {name} übernommen wird.",
  ],
  // What is not there, or too much.
  [
    "Too many plan checks are pending. Try again when the earlier ones are complete.",
    "Zu viele Planprüfungen warten. Erneut versuchen, wenn die früheren fertig sind.",
  ],
  [
    "There is no base map; name a PMTiles file as api.basemap in the configuration.",
    "Es gibt keine Grundkarte; eine PMTiles-Datei als api.basemap in der Konfiguration angeben.",
  ],
  [
    "The operation has no mission {mission}; there are no frames to show.",
    "Der Einsatz hat keine Mission {mission}; es gibt keine Bilder.",
  ],
  ["The operation has no mission {mission}.", "Der Einsatz hat keine Mission {mission}."],
  ["This is a live mission, not a replay.", "Dies ist eine laufende Mission, keine Wiedergabe."],
  ["This mission is not recorded; {missing}.", "Diese Mission wird nicht aufgezeichnet; {missing}."],
  ["there are no frames to show", "es gibt keine Bilder"],
  ["there is no operation that it belongs to", "es gibt keinen Einsatz, zu dem sie gehört"],
  ["there is nothing to hand over", "es gibt nichts zu übergeben"],
  [
    "Finding {id} was marked before the first step; no frame shows it.",
    "Fund {id} wurde vor dem ersten Schritt markiert; kein Bild zeigt ihn.",
  ],
  [
    "latitude_deg, longitude_deg: the place is more than {distance} km from the mission.",
    "Der Ort ist mehr als {distance} km von der Mission entfernt.",
  ],
  [
    "There is no {kind} picture yet; the first one comes with the first step of the scan{condition}.",
    "Es gibt noch kein Bild ({kind}); das erste kommt mit dem ersten Schritt der Suche{condition}.",
  ],
  [", if the configuration has the section [forest]", ", wenn die Konfiguration den Abschnitt [forest] hat"],
  ["There is no plan '{name}'.", "Es gibt keinen Plan „{name}“."],
  ["The plan '{name}' is damaged: {error}.", "Der Plan „{name}“ ist beschädigt: {error}."],
  ["The file is larger than {size} MiB; {remedy}.", "Die Datei ist größer als {size} MiB; {remedy}."],
  ["remove what is not needed", "entfernen, was nicht gebraucht wird"],
  ["leave out what is not needed", "weglassen, was nicht gebraucht wird"],
  // Files with shapes.
  [
    "{latitude}, {longitude} is not a latitude and longitude in degrees; export it in WGS 84 (EPSG:4326).",
    "{latitude}, {longitude} sind keine Breite und Länge in Grad; in WGS 84 (EPSG:4326) exportieren.",
  ],
  [
    "A circle of the file has a radius of {radius} m: give one of 100 km or less.",
    "Ein Kreis der Datei hat einen Radius von {radius} m: einen bis 100 km angeben.",
  ],
  ["A shape of the file has no coordinates.", "Eine Form der Datei hat keine Koordinaten."],
  [
    "{shape} has {count} points; simplify it to {most} or fewer.",
    "{shape} hat {count} Punkte; auf {most} oder weniger vereinfachen.",
  ],
  ["A shape without a name", "Eine Form ohne Namen"],
  ["The shape '{name}'", "Die Form „{name}“"],
  [
    "The file declares a document type or entities, which are refused; remove them.",
    "Die Datei deklariert einen Dokumenttyp oder Entitäten, die abgelehnt werden; entfernen.",
  ],
  [
    "The file holds more than {most} shapes; leave out what is not needed.",
    "Die Datei enthält mehr als {most} Formen; weglassen, was nicht gebraucht wird.",
  ],
  ["The file holds neither polygons nor points.", "Die Datei enthält weder Polygone noch Punkte."],
  [
    "The file is a ZIP archive (KMZ?); unpack it and import the .kml in it.",
    "Die Datei ist ein ZIP-Archiv (KMZ?); entpacken und die .kml darin importieren.",
  ],
  [
    "The file is damaged, or no GeoJSON, KML or QGroundControl plan: {error}.",
    "Die Datei ist beschädigt oder weder GeoJSON, KML noch ein Plan von QGroundControl: {error}.",
  ],
  ["The file is not well-formed KML: {error}.", "Die Datei ist kein wohlgeformtes KML: {error}."],
  [
    "The file's coordinates are in '{system}'; export it in WGS 84 (EPSG:4326).",
    "Die Koordinaten der Datei sind in „{system}“; in WGS 84 (EPSG:4326) exportieren.",
  ],
  // Missions that cannot go on.
  [
    "Only {heard} of {expected} vehicles were heard within {wait} s; check that they are switched on and send to this computer's address and port.{missing}",
    "Nur {heard} von {expected} Drohnen wurden binnen {wait} s gehört; prüfen, ob sie eingeschaltet sind und an Adresse und Port dieses Rechners senden.{missing}",
  ],
  [
    "Only {armed} vehicles armed; the mission needs at least {least}.",
    "Nur bei {armed} Drohnen laufen die Motoren; die Mission braucht mindestens {least}.",
  ],
  ["Preflight did not pass in time. {issues}", "Die Vorflugkontrolle wurde nicht rechtzeitig bestanden. {issues}"],
  ["{problem} in {count} steps ({reasons}).", "{problem} in {count} Schritten ({reasons})."],
];
