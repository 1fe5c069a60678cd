/** German translations of what the station says of plans. */
import type { StationText } from "../../station";

export const plans: readonly StationText[] = [
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
  [
    "Frame rate: at {rate} frames per second the same places are seen at {speed} m/s: {better}, against {worse}. Slower cameras slow the search down.",
    "Bildrate: Mit {rate} Bildern pro Sekunde werden dieselben Stellen bei {speed} m/s gesehen: {better}, statt {worse}. Langsamere Kameras bremsen die Suche.",
  ],
  ["{name} has {points} points; use {most} or fewer.", "{name} hat {points} Punkte; höchstens {most} verwenden."],
  [
    "{name} must be a list of points with two finite coordinates each, in metres.",
    "{name} muss eine Liste von Punkten mit je zwei endlichen Koordinaten in Metern sein.",
  ],
  [
    "{name} must have three or more points that enclose an area.",
    "{name} braucht drei oder mehr Punkte, die eine Fläche einschließen.",
  ],
  [
    "{name} must not cross or touch itself; list its points in order along the edge.",
    "{name} darf sich nicht selbst kreuzen oder berühren; die Punkte der Reihe nach am Rand angeben.",
  ],
  ["{name} reaches to {far}", "{name} reicht bis {far}"],
  ["The {name} point is {far}", "Punkt für {name} liegt {far}"],
  [
    "{far} km from the origin, {most} km are allowed: move it.",
    "{far} km vom Ursprung, {most} km sind erlaubt: verschieben.",
  ],
  [
    "{far} km from the origin, {most} km are allowed: move it; are latitude and longitude swapped?",
    "{far} km vom Ursprung, {most} km sind erlaubt: verschieben; sind Breite und Länge vertauscht?",
  ],
  ["launch", "Start"],
  [
    "Geofence and no-go zones have {points} points; simplify them to {most} in all.",
    "Geofence und Sperrzonen haben {points} Punkte; auf insgesamt {most} vereinfachen.",
  ],
  ["A mission has 1 to 250 vehicles, not {count}.", "Eine Mission hat 1 bis 250 Drohnen, nicht {count}."],
  [
    "Frames of {vehicles} vehicles are {distance} m apart along the legs: too many to predict the probability of detection. Search faster, with fewer vehicles or frames per second, or without describing the forest.",
    "Die Bilder von {vehicles} Drohnen liegen entlang der Bahnen {distance} m auseinander: zu viele, um die Entdeckungswahrscheinlichkeit vorherzusagen. Schneller suchen, mit weniger Drohnen oder Bildern pro Sekunde, oder ohne Beschreibung des Waldes.",
  ],
  [
    "Checking this plan takes more memory than the station has: make the search area smaller, or use fewer vehicles or fewer frames per second.",
    "Die Prüfung dieses Plans braucht mehr Speicher, als die Station hat: Das Suchgebiet verkleinern oder weniger Drohnen oder weniger Bilder pro Sekunde einsetzen.",
  ],
  ["This must be {least} or more, but is {value}.", "Muss mindestens {least} sein, ist aber {value}."],
  [
    "This must lie within {most} m of the origin, but is {value} m.",
    "Darf höchstens {most} m vom Ursprung abweichen, ist aber {value} m.",
  ],
  ["The distance to the geofence must not be negative.", "Der Abstand zum Geofence darf nicht negativ sein."],
  [
    "The highest layer is at {highest} m, {most} m are allowed: lower the layers or the spacing.",
    "Die oberste Höhenebene liegt bei {highest} m, {most} m sind erlaubt: Ebenen oder Abstand verringern.",
  ],
  [
    "The legs can be flown 1 to {most} times, but this is {passes}.",
    "Die Bahnen können 1- bis {most}-mal geflogen werden, hier steht {passes}.",
  ],
  [
    "The search area takes {legs} legs, {most} are allowed: make it smaller, or widen the spacing.",
    "Das Suchgebiet braucht {legs} Bahnen, {most} sind erlaubt: verkleinern oder den Abstand vergrößern.",
  ],
  [
    "The spacing of the vehicles must be above 0, but is {spacing} m.",
    "Der Abstand der Drohnen muss über 0 liegen, ist aber {spacing} m.",
  ],
  [
    "The wanted probability of detection must lie between {least} and {most}.",
    "Die gewünschte Entdeckungswahrscheinlichkeit muss zwischen {least} und {most} liegen.",
  ],
  [
    "A single vehicle looks closer by visiting places around what it has seen, one after the other; the strategy is for two and more.",
    "Eine einzelne Drohne sieht genau hin, indem sie nacheinander Orte um das Gesehene besucht; die Strategie ist für zwei und mehr.",
  ],
  [
    "With a margin of {margin} m a vehicle at full speed may stop outside of the geofence: it needs {stopping}. Leave the margin empty, or fly slower.",
    "Mit {margin} m Abstand kann eine Drohne bei voller Geschwindigkeit erst außerhalb des Geofence anhalten: Sie braucht {stopping}. Den Abstand leer lassen oder langsamer fliegen.",
  ],
  [
    "{total} m, the stopping distance at {speed} m/s: {reaction} m in {time} s of reaction, {braking} m of braking at {deceleration} m/s², {error} m of position error",
    "{total} m, den Anhalteweg bei {speed} m/s: {reaction} m in {time} s Reaktion, {braking} m Bremsen mit {deceleration} m/s², {error} m Positionsfehler",
  ],
  // Points and vehicles that have no way to the legs.
  ["The {name} point is {text}; {remedy}.", "Punkt für {name} liegt {text}; {remedy}."],
  ["Vehicle {id} is {text}; {remedy}.", "Drohne {id} steht {text}; {remedy}."],
  ["Vehicles {ids} are {text}; {remedy}.", "Drohnen {ids} stehen {text}; {remedy}."],
  ["outside of the geofence", "außerhalb des Geofence"],
  // Where the person is likely to be.
  [
    "{share} of the prior probability lies outside of the search area: extend the area, or search there by other means.",
    "{share} der Wahrscheinlichkeit vor der Suche liegen außerhalb des Suchgebiets: Gebiet erweitern oder dort anders suchen.",
  ],
  [
    "Segments outside of the search area, which are not searched: {names}. Extend the area.",
    "Abschnitte außerhalb des Suchgebiets, die nicht abgesucht werden: {names}. Gebiet erweitern.",
  ],
  ["Prior: {reason}", "Vorwissen: {reason}"],
  ["Segments: {reason}", "Abschnitte: {reason}"],
  [
    "No segment of {name} meets the search area: correct the file, or remove it.",
    "Kein Abschnitt von {name} trifft das Suchgebiet: Datei berichtigen oder entfernen.",
  ],
  [
    "{place} is where the elevation model has a hole or ends. Move it, or add a file that covers it.",
    "{place} liegt, wo das Höhenmodell eine Lücke hat oder endet. Verschieben, oder eine Datei hinzufügen, die den Ort abdeckt.",
  ],
  ["The {name} point at {place}", "Punkt für {name} bei {place}"],
  [
    "{latitude}, {longitude} ({x} m {east}, {y} m {north} of the origin)",
    "{latitude}, {longitude} ({x} m {east}, {y} m {north} vom Ursprung)",
  ],
  ["east", "östlich"],
  ["west", "westlich"],
  ["north", "nördlich"],
  ["south", "südlich"],
  // Saved plans, and values of strategies.
  [
    "{name} is not a valid plan name; use up to 50 letters, digits, spaces, points, '-' and '_'.",
    "{name} ist kein gültiger Name für einen Plan; höchstens 50 Buchstaben, Ziffern, Leerzeichen, Punkte, „-“ und „_“ verwenden.",
  ],
  ["The plan {name} cannot be read: {reason}.", "Der Plan {name} kann nicht gelesen werden: {reason}."],
  ["{name} must be true or false, but is {value}.", "{name} muss wahr oder falsch sein, ist aber {value}."],
  ["{name} must be a number, but is {value}.", "{name} muss eine Zahl sein, ist aber {value}."],
  ["{name} must be a finite number, but is {value}.", "{name} muss eine endliche Zahl sein, ist aber {value}."],
];
