/** German translations of what the drivers say: commands that vehicles refuse, and links and cameras. */
import type { StationText } from "../../station";

export const vehicles: readonly StationText[] = [
  // Commands that cannot be sent, that a vehicle refuses, or that it does not carry out.
  ["vehicle {id} refuses to {step}: {reason}", "Drohne {id} lehnt ab ({step}): {reason}"],
  [
    "vehicle {id} has been silent for {silence} s: only hold, return and land are sent to it",
    "Drohne {id} schweigt seit {silence} s: Nur Halten, Rückkehr und Landen werden gesendet",
  ],
  [
    "vehicle {id} was taken over: {reason}. Resume it first",
    "Drohne {id} wurde übernommen: {reason}. Zuerst fortsetzen",
  ],
  [
    "vehicle {id} was taken over: {reason}. {command} is not repeated",
    "Drohne {id} wurde übernommen: {reason}. {command} wird nicht wiederholt",
  ],
  [
    "vehicle {id} is in a failsafe ({failsafe}): only return and land are sent to it",
    "Drohne {id} ist in einer Notfunktion ({failsafe}): Nur Rückkehr und Landen werden gesendet",
  ],
  [
    "vehicle {id} accepted {command}, but telemetry does not show it: check link and vehicle",
    "Drohne {id} hat {command} angenommen, die Telemetrie zeigt aber nichts davon: Funk und Drohne prüfen",
  ],
  [
    "vehicle {id} accepted {command}, but telemetry does not show it ({reason}): check link and vehicle",
    "Drohne {id} hat {command} angenommen, die Telemetrie zeigt aber nichts davon ({reason}): Funk und Drohne prüfen",
  ],
  [
    "vehicle {id} did not acknowledge {command}: check link and vehicle",
    "Drohne {id} hat {command} nicht bestätigt: Funk und Drohne prüfen",
  ],
  [
    "vehicle {id} did not acknowledge {command} ({reason}): check link and vehicle",
    "Drohne {id} hat {command} nicht bestätigt ({reason}): Funk und Drohne prüfen",
  ],
  ["the command to {step}", "den Befehl ({step})"],
  ["{command} for vehicle {id} is superseded by {newest}", "{command} für Drohne {id} ist durch {newest} ersetzt"],
  [
    "two vehicles use system id {id}: change the id of one of them",
    "zwei Drohnen verwenden die System-ID {id}: die ID einer von beiden ändern",
  ],
  [
    "vehicle {id} does not {exchange} in time: check link and vehicle",
    "Drohne {id} antwortet nicht rechtzeitig ({exchange}): Funk und Drohne prüfen",
  ],
  [
    "vehicle {id} reports {mode}, as if a pilot had chosen it",
    "Drohne {id} meldet {mode}, als hätte ein Pilot es gewählt",
  ],
  [
    "this station failed at {count} packets or requests so far, at last {name}: {error}. All others count: compare what is shown with the vehicle, and return it if in doubt",
    "die Bodenstation ist bisher an {count} Paketen oder Anfragen gescheitert, zuletzt {name}: {error}. Alle anderen zählen: Anzeige mit der Drohne vergleichen, im Zweifel zurückkehren lassen",
  ],
  ["vehicle {id} cannot go there: {problem}", "Drohne {id} kann nicht dorthin: {problem}"],
  ["it is not flying, take off first", "sie fliegt nicht, zuerst starten"],
  ["latitude and longitude 0 mean an unknown position", "Breite und Länge 0 bedeuten eine unbekannte Position"],
  ["{values} is not a latitude and longitude in degrees", "{values} sind keine Breite und Länge in Grad"],
  ["the position {values} is not finite", "die Position {values} ist nicht endlich"],
  ["a speed of {speed} m/s is not positive", "eine Geschwindigkeit von {speed} m/s ist nicht positiv"],
  ["a heading of {heading} rad is not finite", "eine Richtung von {heading} rad ist nicht endlich"],
  [
    "a takeoff height of {height} m is impossible: choose one above home",
    "eine Starthöhe von {height} m ist unmöglich: eine über dem Startpunkt wählen",
  ],
  ["vehicle {id} is not armed: arm it before takeoff", "Drohne {id}: Die Motoren laufen nicht; vor dem Start anlassen"],
  [
    "vehicle {id} has no home position yet: wait for its GPS",
    "Drohne {id} hat noch keine Startposition: auf ihr GPS warten",
  ],
  [
    "vehicle {id} does not report that it is on the ground: land it before disarming",
    "Drohne {id} meldet nicht, dass sie am Boden ist: vor dem Abstellen der Motoren landen",
  ],
  [
    "vehicle {id} reports that it is on the ground, {height} m above its home: its motors are stopped by its autopilot or its pilot alone",
    "Drohne {id} meldet, dass sie am Boden ist, {height} m über ihrem Startpunkt: Nur ihr Autopilot oder ihr Pilot stellt ihre Motoren ab",
  ],
  [
    "vehicle {id} is not a PX4 or ArduPilot multicopter: {command} is not supported",
    "Drohne {id} ist kein Multikopter mit PX4 oder ArduPilot: {command} wird nicht unterstützt",
  ],
  // Settings and geofences.
  [
    "vehicle {id} is not a PX4 or ArduPilot multicopter: its parameters are not supported",
    "Drohne {id} ist kein Multikopter mit PX4 oder ArduPilot: Ihre Parameter werden nicht unterstützt",
  ],
  [
    "vehicle {id} does not accept {name} = {value}: set it manually",
    "Drohne {id} nimmt {name} = {value} nicht an: von Hand setzen",
  ],
  ["{name} is not a return setting of vehicle {id}", "{name} ist keine Rückkehreinstellung der Drohne {id}"],
  [
    "a return height of {height} m is impossible: choose one above home",
    "eine Rückkehrhöhe von {height} m ist unmöglich: eine über dem Startpunkt wählen",
  ],
  [
    "vehicle {id} is armed: its return settings can be changed only while disarmed",
    "Drohne {id}: Die Motoren laufen; die Rückkehreinstellungen können nur bei abgestellten Motoren geändert werden",
  ],
  [
    "vehicle {id} refuses a geofence of {count} points: {reason}",
    "Drohne {id} lehnt einen Geofence aus {count} Punkten ab: {reason}",
  ],
  ["vehicle {id} does not report its geofence: {problem}", "Drohne {id} meldet ihren Geofence nicht: {problem}"],
  [
    "the geofence for vehicle {id} has no inclusion polygon",
    "der Geofence für Drohne {id} hat kein Polygon, in dem geflogen werden darf",
  ],
  [
    "the ceiling of the geofence is {below} m below the home of vehicle {id}: nothing was written; check the altitude of the mission's origin",
    "die Obergrenze des Geofence liegt {below} m unter dem Startpunkt der Drohne {id}: nichts wurde geschrieben; Höhe des Ursprungs der Mission prüfen",
  ],
  [
    "vehicle {id} stored a different geofence than the uploaded one: check its messages",
    "Drohne {id} hat einen anderen Geofence gespeichert als den übertragenen: ihre Meldungen prüfen",
  ],
  // Links and cameras.
  [
    "heard at {peer}, but it flew at {former} before this station was restarted: ignored there until it proves to be the same vehicle. If another one has its system id now, end the program and start it again",
    "unter {peer} gehört, flog aber unter {former}, bevor diese Station neu gestartet wurde: wird dort ignoriert, bis sie sich als dieselbe Drohne erweist. Hat jetzt eine andere ihre System-ID, das Programm beenden und neu starten",
  ],
  [
    "the mavsdk driver has failed and no longer sends heartbeats: {error}; restart the service",
    "der MAVSDK-Treiber ist ausgefallen und sendet keine Lebenszeichen mehr: {error}; den Dienst neu starten",
  ],
  [
    "two vehicles use this system id: neither is commanded; change the id of one of them",
    "zwei Drohnen verwenden diese System-ID: Keine wird gesteuert; die ID einer von beiden ändern",
  ],
  [
    "a camera's stream is no longer received: {error}; restart the service",
    "der Strom einer Kamera wird nicht mehr empfangen: {error}; den Dienst neu starten",
  ],
  ["its camera delivers images", "ihre Kamera liefert Bilder"],
];
