/** German translations of what the station says of commands. */
import type { StationText } from "../../station";

export const commands: readonly StationText[] = [
  // Commands: results and refusals.
  ["holds its position", "hält ihre Position"],
  ["lands where it is", "landet, wo sie ist"],
  ["returns to its launch point", "kehrt zum Startpunkt zurück"],
  ["link lost: it cannot be reached", "Funk verloren: nicht erreichbar"],
  ["flown by its pilot", "vom Piloten geflogen"],
  ["is not flying", "fliegt nicht"],
  ["hovers at its waypoint after this step", "schwebt nach diesem Schritt an ihrem Wegpunkt"],
  ["hovers, outside of the swarm", "schwebt außerhalb des Schwarms"],
  ["is back in the swarm", "ist wieder im Schwarm"],
  ["stays on the ground", "bleibt am Boden"],
  ["takes off and flies to the swarm", "startet und fliegt zum Schwarm"],
  ["flies the mission", "fliegt die Mission"],
  ["starts", "startet"],
  ["may take off once, to relieve another vehicle", "darf einmal starten, um eine andere abzulösen"],
  ["Cannot launch: {reason}.", "Starten nicht möglich: {reason}."],
  ["preflight has not passed yet", "Die Vorflugkontrolle ist noch nicht bestanden"],
  ["the mission has started already", "Die Mission hat schon begonnen"],
  ["Cannot begin a new sortie: {reason}.", "Neuer Flug nicht möglich: {reason}."],
  ["a vehicle still flies", "Eine Drohne fliegt noch"],
  ["the mission is not over", "Die Mission ist nicht beendet"],
  ["Cannot override a check: {reason}.", "Ausnahme nicht möglich: {reason}."],
  ["there are no checks yet", "Es gibt noch keine Prüfungen"],
  ["Cannot resume: nothing is paused or held.", "Fortsetzen nicht möglich: Nichts ist angehalten."],
  [
    "Cannot return: all vehicles are landing. Hold them first.",
    "Rückkehr nicht möglich: Alle Drohnen landen. Zuerst halten.",
  ],
  [
    "Cannot join: no vehicle of this mission is on the ground. Name another one.",
    "Einreihen nicht möglich: Keine Drohne dieser Mission ist am Boden. Eine andere nennen.",
  ],
  [
    "The vehicles can no longer be changed: the mission has started.",
    "Die Drohnen können nicht mehr geändert werden: Die Mission hat begonnen.",
  ],
  [
    "The plan can no longer be changed: the mission has started.",
    "Der Plan kann nicht mehr geändert werden: Die Mission hat begonnen.",
  ],
  ["This plan cannot be flown: {reason}", "Dieser Plan kann nicht geflogen werden: {reason}"],
  [
    "Not done: {who} sent {action} meanwhile. {remedy}",
    "Nicht ausgeführt: {who} hat inzwischen {action} gesendet. {remedy}",
  ],
  [
    "Not done: the command arrived with data that were {age} s old, more than {limit} s. {remedy}",
    "Nicht ausgeführt: Der Befehl kam mit Daten, die {age} s alt waren, mehr als {limit} s. {remedy}",
  ],
  [
    "Not done: the command was meant for the mission {mission}. {remedy}",
    "Nicht ausgeführt: Der Befehl galt der Mission {mission}. {remedy}",
  ],
  ["Check the vehicles, then send it again.", "Drohnen prüfen, dann erneut senden."],
  [
    "No vehicle is known to fly, so none was held. Those that are found in the air within {window} s are held: until then use the remote control.",
    "Von keiner Drohne ist bekannt, dass sie fliegt, daher wurde keine gehalten. Wer binnen {window} s in der Luft gefunden wird, wird gehalten: bis dahin Fernsteuerung benutzen.",
  ],
  [
    "Observers cannot send commands. Sign in with the operator code.",
    "Beobachter können keine Befehle senden. Mit dem Bedienercode anmelden.",
  ],
  [
    "Wrong operator code. The service printed the code when it started.",
    "Falscher Bedienercode. Der Dienst hat ihn beim Start ausgegeben.",
  ],
  ["Too many requests from this address.", "Zu viele Anfragen von dieser Adresse."],
  [
    "An override needs a reason: it is kept in the record of the mission.",
    "Eine Ausnahme braucht eine Begründung: Sie steht in der Aufzeichnung der Mission.",
  ],
  // Waypoints that are not flown as requested.
  ["no message for {age} s, limit {limit} s", "keine Meldung seit {age} s, Grenze {limit} s"],
  ["no position for {age} s, limit {limit} s", "keine Position seit {age} s, Grenze {limit} s"],
  ["the floor at {height} m", "die Mindesthöhe bei {height} m"],
  ["the ceiling at {height} m", "die Höchsthöhe bei {height} m"],
  ["the geofence", "der Geofence"],
  ["no-go zone {number}", "Sperrzone {number}"],
];
