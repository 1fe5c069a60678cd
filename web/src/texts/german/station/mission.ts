/** German translations of what the station says of the course of a mission, its links and the station itself. */
import type { StationText } from "../../station";

export const mission: readonly StationText[] = [
  // Phases, and what the mission is doing.
  ["Preflight", "Vorflugkontrolle"],
  ["Arming", "Motoren an"],
  ["Taking off", "Steigflug"],
  ["Forming line", "Aufstellung"],
  ["Converging", "Annäherung"],
  ["Found", "Fund"],
  ["Returning", "Rückflug"],
  ["Finished", "Beendet"],
  ["Connecting", "Verbindungsaufbau"],
  ["Ready", "Startbereit"],
  ["Scanning", "Suche"],
  ["Landing", "Landung"],
  [
    "Waiting for vehicles: {heard} of {expected} heard.{missing}",
    "Warten auf Drohnen: {heard} von {expected} gehört.{missing}",
  ],
  [" Missing: {missing}.", " Es fehlen: {missing}."],
  [
    "Preflight: {issues}. First: vehicle {id}, {name}: {text}; {remedy}.",
    "Vorflugkontrolle: {issues}. Zuerst: Drohne {id}, {name}: {text}; {remedy}.",
  ],
  [
    "Preflight: {issues}. First: vehicle {id}, {name}: {text}.",
    "Vorflugkontrolle: {issues}. Zuerst: Drohne {id}, {name}: {text}.",
  ],
  [
    "Preflight: {issues}. First: {name}: {text}; {remedy}.",
    "Vorflugkontrolle: {issues}. Zuerst: {name}: {text}; {remedy}.",
  ],
  ["Preflight: {issues}. First: {name}: {text}.", "Vorflugkontrolle: {issues}. Zuerst: {name}: {text}."],
  ["1 blocking issue", "1 Hindernis"],
  ["{count} blocking issues", "{count} Hindernisse"],
  ["Ready to launch{passed}.", "Startbereit{passed}."],
  [", {overridden} failed checks overridden", ", {overridden} Prüfungen mit Ausnahme"],
  ["Arming.", "Motoren laufen an."],
  ["Climbing to the altitude layers.", "Steigen auf die Höhenebenen."],
  ["Forming the line for leg {leg} of {legs}.", "Aufstellung für Bahn {leg} von {legs}."],
  ["Step {step}: capturing images.", "Schritt {step}: Bilder werden aufgenommen."],
  ["Step {step}: searching in flight.", "Schritt {step}: Suche im Flug."],
  ["Step {step}: moving.", "Schritt {step}: Bewegung."],
  ["Waiting for {count} lost vehicles.", "Warten auf {count} Drohnen ohne Funk."],
  ["Returning: flying home in the altitude layers.", "Rückflug in den Höhenebenen."],
  ["Landing.", "Landung."],
  ["Landing: stopping first.", "Landung: Die Drohnen halten zuerst an."],
  ["Landing: waiting for vehicle {ids}.", "Landung: Warten auf Drohne {ids}."],
  ["Landing: moving apart first.", "Landung: Die Drohnen fliegen erst auseinander."],
  ["Held: all vehicles stop where they are.", "Gehalten: Alle Drohnen bleiben, wo sie sind."],
  ["Aborted: airborne vehicles return on their own.", "Abgebrochen: Drohnen in der Luft kehren selbst zurück."],
  ["Aborted before any motor was started.", "Abgebrochen, bevor ein Motor lief."],
  [
    "Mission over: {landed} of {flown} vehicles landed{elsewhere}.",
    "Mission beendet: {landed} von {flown} Drohnen gelandet{elsewhere}.",
  ],
  [", {count} of them away from their launch points: {ids}", ", davon {count} abseits ihrer Startpunkte: {ids}"],
  [", vehicle {id} {distance} m from its launch point", ", Drohne {id} {distance} m vom Startpunkt entfernt"],
  [
    "Mission {mission} taken up in the air. Resume, return or land.",
    "Mission {mission} in der Luft übernommen. Fortsetzen, zurückkehren oder landen.",
  ],
  [
    "Mission {mission} cannot be taken up: the plan has changed. Return or land its vehicles",
    "Mission {mission} kann nicht übernommen werden: Der Plan wurde geändert. Drohnen zurückholen oder landen",
  ],
  ["Sortie {number}. {text}", "Flug {number}. {text}"],
  ["The area is searched: it is proposed again.", "Das Gebiet ist abgesucht: Es wird noch einmal vorgeschlagen."],
  [
    "The part of the area that is not searched yet is proposed.",
    "Vorgeschlagen ist der Teil des Gebiets, der noch nicht abgesucht ist.",
  ],
  [
    "The whole area is proposed: no leg of it was flown to its end.",
    "Vorgeschlagen ist das ganze Gebiet: Keine Bahn wurde zu Ende geflogen.",
  ],
  [
    "The whole area is proposed: no leg of its last pass was flown to its end.",
    "Vorgeschlagen ist das ganze Gebiet: Im letzten Durchgang wurde keine Bahn zu Ende geflogen.",
  ],
  // Links.
  [
    "link lost for {age} s: its own failsafe flies it now. Check its link{cause}",
    "Funk seit {age} s verloren: Ihre Notfunktion fliegt sie. Funkverbindung prüfen{cause}",
  ],
  ["link restored", "Funk wieder da"],
  ["link restored{how}", "Funk wieder da{how}"],
  [
    " after {silent} s: the mission is over, so it is led home",
    " nach {silent} s: Die Mission ist beendet, sie wird nach Hause geführt",
  ],
  [
    " after {silent} s: it hovers, as an operator has ordered, and the mission is over. Return it",
    " nach {silent} s: Sie schwebt auf Anweisung eines Bedieners, und die Mission ist beendet. Zurückholen",
  ],
  [" after {silent} s: it goes on in the swarm", " nach {silent} s: Sie fliegt weiter im Schwarm"],
  [
    " after {silent} s: it waits outside of the swarm. Resume it, or return it",
    " nach {silent} s: Sie wartet außerhalb des Schwarms. Fortsetzen oder zurückholen",
  ],
  [
    ", but it left the swarm: {reason}. It is left alone until it is resumed",
    ", aber sie hat den Schwarm verlassen: {reason}. Sie wird nicht gesteuert, bis sie fortgesetzt wird",
  ],
  [
    ". This station was unresponsive for {stall} s meanwhile: its own overload may be the cause",
    ". Diese Station reagierte inzwischen {stall} s nicht: Ihre Überlastung kann die Ursache sein",
  ],
  [
    ". This station is overloaded, which may be the cause: close other programs on this computer",
    ". Diese Station ist überlastet, das kann die Ursache sein: andere Programme auf diesem Rechner schließen",
  ],
  [
    ". Its messages arrive {late} s late: this station or the link may be overloaded",
    ". Ihre Meldungen kommen {late} s zu spät: Station oder Funk sind eventuell überlastet",
  ],
  ["heard at {peer}, autopilot {autopilot}", "gehört unter {peer}, Autopilot {autopilot}"],
  ["is now reached at {peer}", "ist jetzt unter {peer} erreichbar"],
  ["has restarted", "wurde neu gestartet"],
  ["first heard during the mission: it can join", "zum ersten Mal während der Mission gehört: Sie kann sich einreihen"],
  [
    "two vehicles use this system id: neither is commanded; change the id of one of them (MAV_SYSID, SYSID_THISMAV or MAV_SYS_ID)",
    "zwei Drohnen verwenden diese System-ID: Keine wird gesteuert; die ID einer von beiden ändern (MAV_SYSID, SYSID_THISMAV oder MAV_SYS_ID)",
  ],
  ["its system id is unique again", "ihre System-ID ist wieder eindeutig"],
  [
    "another sender, at {peer}, uses its system id: ignored. Commands go to {address}",
    "ein anderer Sender, {peer}, verwendet ihre System-ID: wird ignoriert. Befehle gehen an {address}",
  ],
  [
    "another ground station uses our system id {id}: change one of them",
    "eine andere Bodenstation verwendet unsere System-ID {id}: eine von beiden ändern",
  ],
  [
    "packets of system id {id} at {peer} are refused: {reason}",
    "Pakete der System-ID {id} von {peer} werden abgelehnt: {reason}",
  ],
  ["{address} lost; reconnecting", "{address} verloren; Verbindung wird aufgebaut"],
  ["{address} restored", "{address} wieder da"],
  [
    "telemetry is {delay} s old when it is read: this station or its link is overloaded. Close other programs on this computer, and check the link",
    "Telemetrie ist beim Lesen {delay} s alt: Station oder Funk sind überlastet. Andere Programme auf diesem Rechner schließen und Funk prüfen",
  ],
  ["telemetry arrives in time again", "Telemetrie kommt wieder rechtzeitig an"],
  [
    "the mavlink driver has failed and no longer sends heartbeats: {error}; restart the service",
    "der MAVLink-Treiber ist ausgefallen und sendet keine Lebenszeichen mehr: {error}; den Dienst neu starten",
  ],
  ["the MAVLink traffic is no longer recorded: {error}", "der MAVLink-Verkehr wird nicht mehr aufgezeichnet: {error}"],
  // This station.
  ["terrain: {text}", "Gelände: {text}"],
  [
    "Station unresponsive for {stall} s: no telemetry received, no commands sent. Close other programs on this computer",
    "Station reagierte {stall} s nicht: keine Telemetrie empfangen, keine Befehle gesendet. Andere Programme auf diesem Rechner schließen",
  ],
  [
    "This station is overloaded: {missing}. Close other programs on this computer",
    "Diese Station ist überlastet: {missing}. Andere Programme auf diesem Rechner schließen",
  ],
  [
    "The disk does not answer: {missing}. Check the disk",
    "Der Datenträger antwortet nicht: {missing}. Datenträger prüfen",
  ],
  ["{what} may be missing in the record", "{what} fehlt eventuell in der Aufzeichnung"],
  [
    "The disk is too slow: {count} events were not recorded",
    "Der Datenträger ist zu langsam: {count} Ereignisse wurden nicht aufgezeichnet",
  ],
  ["The mission continues without recording: {reason}.", "Die Mission geht ohne Aufzeichnung weiter: {reason}."],
  ["Recording resumed; {count} records were lost.", "Aufzeichnung läuft wieder; {count} Einträge sind verloren."],
  ["Internal error, all vehicles return: {error}", "Interner Fehler, alle Drohnen kehren zurück: {error}"],
  ["{phase} makes no progress: all vehicles return.", "{phase} kommt nicht voran: Alle Drohnen kehren zurück."],
  [
    "All vehicles are lost: the mission is over. Their own failsafes fly them.",
    "Alle Drohnen sind ohne Funk: Die Mission ist beendet. Ihre Notfunktionen fliegen sie.",
  ],
  ["Automatic start cancelled: {reason}. Launch by hand", "Automatischer Start abgesagt: {reason}. Von Hand starten"],
  ["{who} has acted", "{who} hat eingegriffen"],
  ["an operator", "ein Bediener"],
  [
    "the last mission, {mission}, did not end: vehicles may still fly",
    "die letzte Mission, {mission}, wurde nicht beendet: Drohnen fliegen eventuell noch",
  ],
  ["vehicles were found in the air", "Drohnen sind in der Luft"],
  ["{program} is available again", "{program} ist wieder verfügbar"],
];
