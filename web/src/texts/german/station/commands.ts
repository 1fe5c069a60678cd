/** German translations of what the station says of commands and plans. */
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
  ["the mission is returning already", "die Mission ist schon auf dem Rückflug"],
  ["Cannot start: {reason}.", "Starten nicht möglich: {reason}."],
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
  // Plans.
  [
    "The search area leaves the geofence; shrink it, or widen it.",
    "Das Suchgebiet ragt über den Geofence hinaus; das Gebiet verkleinern oder den Geofence erweitern.",
  ],
  [
    "The no-go zones cover the whole search area; nothing is left to search.",
    "Die Sperrzonen bedecken das ganze Suchgebiet; nichts bleibt zu suchen.",
  ],
  ["{name} is empty; draw it.", "{name} ist leer; zeichnen."],
  ["The search area", "Das Suchgebiet"],
  ["The geofence", "Der Geofence"],
  ["A no-go zone", "Eine Sperrzone"],
  ["This must be above 0, but is {value}.", "Muss über 0 liegen, ist aber {value}."],
  ["This must be {greatest} or less, but is {value}.", "Darf höchstens {greatest} sein, ist aber {value}."],
  ["The field of view must lie between 1 and 170 degrees.", "Der Bildwinkel muss zwischen 1 und 170 Grad liegen."],
  ["The battery's reserve must lie between 0 and 90 %.", "Die Akkureserve muss zwischen 0 und 90 % liegen."],
  [
    "It takes {fewest} vehicles, {looking} that look closely and {scanning} that scan on: with {vehicles}, all look closely.",
    "Dafür braucht es {fewest} Drohnen, {looking} zum genauen Hinsehen und {scanning} zum Weitersuchen: Mit {vehicles} sehen alle genau hin.",
  ],
  [
    "Layers of {spacing} m are too close: vehicles keep {separation} m from one another.",
    "Höhenebenen von {spacing} m sind zu eng: Drohnen halten {separation} m Abstand.",
  ],
  [
    "The lowest layer must be above the focal plane, which is at {height} m.",
    "Die unterste Höhenebene muss über der Fokusebene bei {height} m liegen.",
  ],
  [
    "The floor of {floor} m is above the lowest layer of {lowest} m.",
    "Die Mindesthöhe von {floor} m liegt über der untersten Höhenebene von {lowest} m.",
  ],
  [
    "The ceiling of {ceiling} m is below the highest of {vehicles} layers, {highest} m: raise it, or lower the layers or their spacing.",
    "Die Höchsthöhe von {ceiling} m liegt unter der obersten von {vehicles} Höhenebenen, {highest} m: anheben, oder die Ebenen oder ihren Abstand verringern.",
  ],
  [
    "The lowest layer of {lowest} m is not above the tree tops, {canopy} m.",
    "Die unterste Höhenebene von {lowest} m liegt nicht über den Baumkronen, {canopy} m.",
  ],
  [
    "Layers of {spacing} m fail preflight: with a separation of {separation} m they leave no room for gusts; {least} m and more do where heights are known by RTK.",
    "Höhenebenen von {spacing} m bestehen die Vorflugkontrolle nicht: Bei einem Abstand von {separation} m lassen sie keinen Raum für Böen; {least} m und mehr genügen, wo Höhen durch RTK bekannt sind.",
  ],
  [
    "Layers of {spacing} m need heights known by RTK; without it, {least} m and more are safe.",
    "Höhenebenen von {spacing} m brauchen RTK-Höhen; ohne RTK sind {least} m und mehr sicher.",
  ],
  [
    "The highest layer is at {highest} m; most countries allow {usual} m above the ground without a permission: lower the layers or their spacing, or fly fewer vehicles.",
    "Die oberste Höhenebene liegt bei {highest} m; die meisten Länder erlauben {usual} m über Grund ohne Genehmigung: Ebenen oder Abstand verringern, oder weniger Drohnen fliegen.",
  ],
  [
    "The legs sweep {covered} of the search area; the rest lies in no-go zones, beside the legs, or between them on high ground, where the swath is narrower.",
    "Die Bahnen erfassen {covered} des Suchgebiets; der Rest liegt in Sperrzonen, neben den Bahnen oder dazwischen auf hohem Boden, wo der Streifen schmaler ist.",
  ],
  [
    "The flight takes {battery} of a battery, and the reserve leaves {left}: the search ends before its last leg; use a smaller area or more vehicles.",
    "Der Flug braucht {battery} eines Akkus, die Reserve lässt {left}: Die Suche endet vor der letzten Bahn; kleineres Gebiet oder mehr Drohnen.",
  ],
  [
    "The flight takes {flight} min, but all vehicles return after {search} min: the search ends before its last leg; allow more time, or make the area smaller.",
    "Der Flug dauert {flight} min, aber alle Drohnen kehren nach {search} min zurück: Die Suche endet vor der letzten Bahn; mehr Zeit geben oder das Gebiet verkleinern.",
  ],
  [
    "The search area comes within {nearest} m of the geofence, whose margin is {margin} m: vehicles do not fly above what lies in the margin. Widen the geofence, fly slower, or lower the margin.",
    "Das Suchgebiet liegt bis zu {nearest} m am Geofence, dessen Abstand {margin} m ist: Drohnen fliegen nicht über das, was darin liegt. Geofence erweitern, langsamer fliegen oder Abstand verringern.",
  ],
  ["Heading {heading}°: {better}, against {worse}.", "Richtung {heading}°: {better}, statt {worse}."],
  ["{legs} legs, {time}, {battery} % of the battery", "{legs} Bahnen, {time}, {battery} % des Akkus"],
  ["{legs} leg, {time}, {battery} % of the battery", "{legs} Bahn, {time}, {battery} % des Akkus"],
  [
    "Layers: heights of vehicles without RTK differ by more than a metre.",
    "Höhenebenen: Höhen von Drohnen ohne RTK weichen um mehr als einen Meter ab.",
  ],
  [
    "Search speed: at {speed} m/s and {rate} frames per second a camera's frames are {apart} m apart, more than the vehicles, {spacing} m: the ground is seen through fewer gaps.",
    "Suchgeschwindigkeit: Bei {speed} m/s und {rate} Bildern pro Sekunde liegen die Bilder einer Kamera {apart} m auseinander, mehr als die Drohnen, {spacing} m: Der Boden wird durch weniger Lücken gesehen.",
  ],
];
