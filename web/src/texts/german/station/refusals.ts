/** German translations of why the station does not do what was asked of it, of a mission or of a vehicle. */
import type { StationText } from "../../station";

export const refusals: readonly StationText[] = [
  // Names of actions, states and uses, as they are filled in below.
  ["pause", "Pause"],
  ["resume", "Fortsetzen"],
  ["hold", "Halten"],
  ["return", "Rückkehr"],
  ["land", "Landen"],
  ["abort", "Abbruch"],
  ["choose vehicles", "Auswahl der Drohnen"],
  ["set the focal plane", "Einstellen der Fokusebene"],
  ["confirm vehicles as ready", "Bestätigung der Bereitschaft"],
  ["mark vehicles as not ready", "Markierung als nicht bereit"],
  ["override a check", "Ausnahme für eine Prüfung"],
  ["begin a new sortie", "Neuer Flug"],
  ["join", "Einreihen"],
  ["paused", "angehalten"],
  ["held", "gehalten"],
  ["holding", "gehalten"],
  ["standing by", "bereit"],
  ["joining", "im Anflug"],
  ["in the swarm", "im Schwarm"],
  ["returning", "auf dem Rückflug"],
  ["landing", "bei der Landung"],
  ["point", "Punkt"],
  ["line", "Linie"],
  ["area", "Gebiet"],
  ["none", "keine"],
  // Actions.
  [
    "Cannot {action} for single vehicles: this concerns the whole mission; leave the vehicles out.",
    "{action} ist für einzelne Drohnen nicht möglich: Das betrifft die ganze Mission; keine Drohnen nennen.",
  ],
  [
    "Cannot {action} with a focal height; leave the height out.",
    "{action} ist mit einer Fokushöhe nicht möglich; die Höhe weglassen.",
  ],
  ["A mission needs at least one vehicle; name it.", "Eine Mission braucht mindestens eine Drohne; sie nennen."],
  [
    "An override concerns one check of one vehicle; name it, and the reason.",
    "Eine Ausnahme betrifft eine Prüfung einer Drohne; beide nennen, mit der Begründung.",
  ],
  ["Cannot pause: the mission is {state} already.", "Pause nicht möglich: Die Mission ist schon {state}."],
  [
    "Name the vehicles that are ready, or are not: each is confirmed on its own.",
    "Die Drohnen nennen, die bereit sind oder nicht: Jede wird einzeln bestätigt.",
  ],
  [
    "No vehicle was named; name at least one, or none at all for the whole mission.",
    "Keine Drohne genannt; mindestens eine nennen, oder gar keine für die ganze Mission.",
  ],
  [
    "The whole mission has one focal plane; leave the vehicles out.",
    "Die ganze Mission hat eine Fokusebene; keine Drohnen nennen.",
  ],
  ["Cannot {action} in the phase {phase}.", "{action} ist in der Phase {phase} nicht möglich."],
  ["Cannot {action}: {reason}.", "{action} nicht möglich: {reason}."],
  ["Cannot {action}: the mission is over.", "{action} nicht möglich: Die Mission ist beendet."],
  [
    "Cannot confirm vehicles for the relay in the phase {phase}.",
    "Drohnen können in der Phase {phase} nicht für die Ablösung bestätigt werden.",
  ],
  ["Cannot {action}: no vehicle is flying yet.", "{action} nicht möglich: Noch fliegt keine Drohne."],
  ["the mission has not started", "Die Mission hat nicht begonnen"],
  [
    "Cannot resume: the altitude layers follow an elevation model that is not loaded. Return or land the vehicles.",
    "Fortsetzen nicht möglich: Die Höhenebenen folgen einem Höhenmodell, das nicht geladen ist. Drohnen zurückholen oder landen.",
  ],
  [
    "Cannot resume: the search needs {fewest} vehicles that follow the station, and has {able} ({reasons}). Return or land the vehicles, or resume when enough of them follow again.",
    "Fortsetzen nicht möglich: Die Suche braucht {fewest} Drohnen, die der Station folgen, und hat {able} ({reasons}). Drohnen zurückholen oder landen, oder fortsetzen, wenn wieder genug folgen.",
  ],
  [
    "Cannot resume: the search needs {fewest} vehicles that follow the station, and has {able}. Return or land the vehicles, or resume when enough of them follow again.",
    "Fortsetzen nicht möglich: Die Suche braucht {fewest} Drohnen, die der Station folgen, und hat {able}. Drohnen zurückholen oder landen, oder fortsetzen, wenn wieder genug folgen.",
  ],
  [
    "No vehicle {id} in this mission; the vehicles are: {known}.",
    "Keine Drohne {id} in dieser Mission; die Drohnen sind: {known}.",
  ],
  [
    "The focal height must be below the lowest layer, {lowest} m above the origin; it is {height}.",
    "Die Fokushöhe muss unter der untersten Höhenebene liegen, {lowest} m über dem Ursprung; sie ist {height}.",
  ],
  [
    "The focal height must be at least {lowest} m above the origin, {depth} m below the plane that is set; it is {height}.",
    "Die Fokushöhe muss mindestens {lowest} m über dem Ursprung liegen, {depth} m unter der eingestellten Ebene; sie ist {height}.",
  ],
  // Overrides of checks.
  ["{name} of vehicle {id} cannot be overridden: {remedy}.", "Keine Ausnahme für {name} der Drohne {id}: {remedy}."],
  [
    "No check {name} of vehicle {id}; its checks are: {known}.",
    "Keine Prüfung {name} der Drohne {id}; ihre Prüfungen sind: {known}.",
  ],
  [
    "Nothing to override: {name} of vehicle {id} has not failed ({text}).",
    "Keine Ausnahme nötig: {name} der Drohne {id} ist nicht fehlgeschlagen ({text}).",
  ],
  ["the operator", "der Bediener"],
  ["operator", "Bediener"],
  // Vehicles.
  [
    "does not follow this station: its failsafe is active ({failsafe})",
    "folgt dieser Station nicht: Ihre Notfunktion ist aktiv ({failsafe})",
  ],
  ["does not follow this station: its mode is {mode}", "folgt dieser Station nicht: Ihr Modus ist {mode}"],
  ["is neither paused nor held ({task})", "ist weder angehalten noch gehalten ({task})"],
  [
    "stays held: {problem}. Return it, land it, or resume it when that is over",
    "bleibt gehalten: {problem}. Zurückholen, landen, oder fortsetzen, wenn das vorbei ist",
  ],
  ["is not in the swarm ({task})", "ist nicht im Schwarm ({task})"],
  ["is part of the mission already ({task})", "gehört schon zur Mission ({task})"],
  [
    "vehicle {id} is or may come below it: hold or return that one, or land all",
    "Drohne {id} ist unter ihr oder kann dorthin kommen: diese halten oder zurückholen, oder alle landen",
  ],
  [
    "vehicle {id} is or may come below it before it stops: hold it, then land it",
    "Drohne {id} ist unter ihr oder kann dorthin kommen, bevor sie steht: sie halten, dann landen",
  ],
  ["vehicle {id} stands on the ground below it: return it", "Drohne {id} steht unter ihr am Boden: sie zurückholen"],
  [
    "vehicle {id} is or may come above its launch point: try again when it has passed",
    "Drohne {id} ist über ihrem Startpunkt oder kann dorthin kommen: erneut versuchen, wenn sie vorbei ist",
  ],
  [
    "was taken over: {reason}. Resume this vehicle alone",
    "wurde übernommen: {reason}. Diese Drohne einzeln fortsetzen",
  ],
  ["its home position is not known yet", "ihre Startposition ist noch nicht bekannt"],
  ["its position is not known yet", "ihre Position ist noch nicht bekannt"],
  [
    "stands {distance} m from its launch point, and the height of the ground there is not known: carry it back, or restart it on ground that is level with the launch points",
    "steht {distance} m von ihrem Startpunkt, und die Höhe des Bodens dort ist nicht bekannt: zurücktragen, oder auf Boden neu starten, der so hoch liegt wie die Startpunkte",
  ],
  [
    "stands {distance} m from the launch point of vehicle {id}, which may land there: carry it {least} m away",
    "steht {distance} m vom Startpunkt der Drohne {id}, die dort landen kann: {least} m weit wegtragen",
  ],
  [
    "its autopilot has its home {distance} m from where it stands. Join it again",
    "ihr Autopilot hat seinen Startpunkt {distance} m von ihrem Standort. Erneut einreihen",
  ],
  [
    "its autopilot has its home {distance} m from where it stands, and would return there. Restart it where it stands",
    "ihr Autopilot hat seinen Startpunkt {distance} m von ihrem Standort und würde dorthin zurückkehren. An ihrem Standort neu starten",
  ],
  [
    "its autopilot has moved its home by {height} m in height. Join it again",
    "ihr Autopilot hat die Höhe seines Startpunkts um {height} m geändert. Erneut einreihen",
  ],
  ["its home position is not known", "ihre Startposition ist nicht bekannt"],
  [
    "it has not reported its position since its motors started",
    "sie hat ihre Position nicht gemeldet, seit ihre Motoren laufen",
  ],
  ["it has no altitude layer or no position", "sie hat keine Höhenebene oder keine Position"],
  ["it cannot climb to its layer, {reason}", "sie kann nicht auf ihre Höhenebene steigen, {reason}"],
  ["its launch point lies on the wrong side of {boundary}", "ihr Startpunkt liegt auf der falschen Seite: {boundary}"],
  [
    "no altitude layer is free below the ceiling at {height} m",
    "unter der Höchsthöhe von {height} m ist keine Höhenebene frei",
  ],
  [
    "the elevation model that its altitude layer follows is not loaded",
    "das Höhenmodell, dem ihre Höhenebene folgt, ist nicht geladen",
  ],
  ["was called off before it started", "wurde vor dem Start abgesagt"],
  ["it was called off before it started", "der Start wurde abgesagt"],
  [
    "has taken off, or is about to: hold, return or land it",
    "ist gestartet oder startet gerade: halten, zurückholen oder landen",
  ],
  ["is not on the ground with stopped motors", "steht nicht mit abgestellten Motoren am Boden"],
  ["its last position is {age} s old", "ihre letzte Position ist {age} s alt"],
  ["no position yet", "noch keine Position"],
  ["still moving at {speed} m/s", "bewegt sich noch mit {speed} m/s"],
  // Findings, proposals, notices.
  [
    "There are {count} findings already, the most that are kept.",
    "Es gibt schon {count} Funde, mehr werden nicht geführt.",
  ],
  ["There is no finding {id}.", "Es gibt keinen Fund {id}."],
  [
    "There is no notice {id} in this mission; the latest one is {latest}.",
    "In dieser Mission gibt es keine Meldung {id}; die letzte ist {latest}.",
  ],
  ["{who} has decided about this proposal already.", "{who} hat über diesen Vorschlag schon entschieden."],
  ["Another operator", "Ein anderer Bediener"],
  [
    "A {shape} of this form cannot be used as {use}; dismiss it.",
    "Dieser Vorschlag ({shape}) kann nicht so verwendet werden ({use}); verwerfen.",
  ],
  [
    "There is no proposal {id} any more: its sender has changed or deleted it.",
    "Den Vorschlag {id} gibt es nicht mehr: Der Absender hat ihn geändert oder gelöscht.",
  ],
  [
    "The place is more than {distance} km from the mission; dismiss it.",
    "Der Ort ist mehr als {distance} km von der Mission entfernt; verwerfen.",
  ],
  ["The decision is not kept: {reason}.", "Die Entscheidung wird nicht gespeichert: {reason}."],
  // The service.
  [
    "This service only shows a mission: it cannot be commanded or changed.",
    "Dieser Dienst zeigt eine Mission nur: Sie kann nicht gesteuert oder geändert werden.",
  ],
  [
    "This service only shows a mission: its findings cannot be changed.",
    "Dieser Dienst zeigt eine Mission nur: Ihre Funde können nicht geändert werden.",
  ],
  [
    "The mission's origin is not known yet: wait until a vehicle has reported its home.",
    "Der Ursprung der Mission ist noch nicht bekannt: warten, bis eine Drohne ihre Startposition gemeldet hat.",
  ],
  [
    "The mission's origin is not known yet: wait until a vehicle has reported its home, or give mission.origin_deg in the configuration.",
    "Der Ursprung der Mission ist noch nicht bekannt: warten, bis eine Drohne ihre Startposition gemeldet hat, oder mission.origin_deg in der Konfiguration angeben.",
  ],
  [
    "The plan cannot be shown in degrees before a vehicle has reported its home.",
    "Der Plan kann erst in Grad gezeigt werden, wenn eine Drohne ihre Startposition gemeldet hat.",
  ],
  [
    "A hand-over is being made already; try again in a moment.",
    "Eine Übergabe wird gerade erstellt; gleich noch einmal versuchen.",
  ],
  [
    "A video is being made already; try again in a moment.",
    "Ein Video wird gerade erstellt; gleich noch einmal versuchen.",
  ],
  ["No video is ready: make one in the view Wall.", "Kein Video ist fertig: eines in der Ansicht Wand erstellen."],
  [
    "This mission is not recorded; there are no pictures for a video.",
    "Diese Mission wird nicht aufgezeichnet; es gibt keine Bilder für ein Video.",
  ],
  ["The video cannot be written: {reason}.", "Das Video kann nicht geschrieben werden: {reason}."],
  [
    "The video cannot be made: see the log of the station.",
    "Das Video kann nicht erstellt werden: siehe Protokoll der Bodenstation.",
  ],
  [
    "The disk has less than {count} GB left, which the recording of the mission may need: delete files, or make the video on another machine.",
    "Auf dem Datenträger sind weniger als {count} GB frei, die die Aufzeichnung der Mission brauchen kann: Dateien löschen oder das Video auf einem anderen Rechner erstellen.",
  ],
  [
    "{folder} has no pictures; they come with the first step of a search",
    "{folder} enthält keine Bilder; sie kommen mit dem ersten Schritt einer Suche.",
  ],
  ["The record has no tile {tile}; it has {others}.", "Die Aufzeichnung hat keine Kachel {tile}; sie hat {others}."],
  [
    "{folder}: the pictures lie more than {hours} h apart; the times are damaged",
    "{folder}: Die Bilder liegen mehr als {hours} h auseinander; die Zeiten sind beschädigt.",
  ],
  [
    "{count} requests for pictures wait already; try again in a moment.",
    "{count} Anfragen nach Bildern warten schon; gleich noch einmal versuchen.",
  ],
  ["{problem}; try again in a moment.", "{problem}; gleich noch einmal versuchen."],
];
