/** German translations of what the station says of vehicles in flight. */
import type { StationText } from "../../station";

export const flight: readonly StationText[] = [
  // Vehicles in flight.
  ["stays on the ground: {reason}", "bleibt am Boden: {reason}"],
  [
    "did not reach its altitude layer: it holds, outside of the swarm. Return it",
    "hat ihre Höhenebene nicht erreicht: Sie hält außerhalb des Schwarms. Zurückholen",
  ],
  ["did not reach its place in the line in time", "hat ihren Platz in der Linie nicht rechtzeitig erreicht"],
  ["has not reached its waypoint in time", "hat ihren Wegpunkt nicht rechtzeitig erreicht"],
  [
    "left the swarm: it is on the ground and its motors have stopped. Check it on site",
    "hat den Schwarm verlassen: Sie ist am Boden, die Motoren stehen. Vor Ort prüfen",
  ],
  [
    "reports that its motors have stopped, but not that it is on the ground. Check it on site",
    "meldet stehende Motoren, aber nicht, dass sie am Boden ist. Vor Ort prüfen",
  ],
  [
    "left the swarm: {reason}. It is left alone until it is resumed",
    "hat den Schwarm verlassen: {reason}. Sie wird nicht gesteuert, bis sie fortgesetzt wird",
  ],
  ["its mode changed to {mode}, not by this station", "ihr Modus wechselte auf {mode}, nicht durch diese Station"],
  ["{reason}, not by this station", "{reason}, nicht durch diese Station"],
  ["its mode changed to {mode}", "ihr Modus wechselte auf {mode}"],
  ["its pilot has stopped its motors", "ihr Pilot hat die Motoren abgestellt"],
  [
    "its failsafe is active ({failsafe}, mode {mode}): only return and land are sent to it",
    "ihre Notfunktion ist aktiv ({failsafe}, Modus {mode}): Nur Rückkehr und Landen werden gesendet",
  ],
  [
    "it flies to a target of another station or pilot",
    "sie fliegt zu einem Ziel einer anderen Station oder eines Piloten",
  ],
  [
    "it reports no target any more, as when another station sets its attitude",
    "sie meldet kein Ziel mehr, wie wenn eine andere Station ihre Lage vorgibt",
  ],
  ["cannot take off for the relay: {reason}", "kann nicht zur Ablösung starten: {reason}"],
  [
    "has another battery, and is ready to relieve others (simulated)",
    "hat einen anderen Akku und kann andere ablösen (simuliert)",
  ],
  [
    "{text}; it was taken over before: {reason}. Resume this vehicle alone",
    "{text}; sie wurde zuvor übernommen: {reason}. Diese Drohne einzeln fortsetzen",
  ],
  ["airborne when first heard: holding, like all vehicles", "beim ersten Kontakt in der Luft: wird wie alle gehalten"],
  [
    "airborne again after its landing. Hold it, return it or land it",
    "nach der Landung wieder in der Luft. Halten, zurückholen oder landen",
  ],
  ["landed", "gelandet"],
  ["landed {distance} m from its launch point", "{distance} m vom Startpunkt entfernt gelandet"],
  ["has not reported that it landed: check it on site", "hat die Landung nicht gemeldet: vor Ort prüfen"],
  [
    "link lost: its own failsafe lands it. Check it on site",
    "Funk verloren: Ihre Notfunktion landet sie. Vor Ort prüfen",
  ],
  ["link lost", "Funk verloren"],
  ["stops on its way: {reason}", "hält auf dem Weg an: {reason}"],
  [
    "must not fly on towards home now, so it hovers and tries again ({reason})",
    "darf jetzt nicht nach Hause weiterfliegen, schwebt und versucht es erneut ({reason})",
  ],
  [
    "lands beside its landing place: vehicle {id} stands there",
    "landet neben ihrem Landeplatz: Dort steht Drohne {id}",
  ],
  [
    "has not begun to land: it is told again until it does",
    "hat die Landung nicht begonnen: Sie wird erneut dazu angewiesen, bis sie landet",
  ],
  ["vehicle {id} stands on the ground below it", "Drohne {id} steht unter ihr am Boden"],
  [
    "hovers, as an operator has ordered: resume, return or land it",
    "schwebt auf Anweisung eines Bedieners: fortsetzen, zurückholen oder landen",
  ],
  ["returns on its own: {reason}", "kehrt allein zurück: {reason}"],
  [
    "returns by its autopilot, at the autopilot's own height",
    "kehrt durch ihren Autopiloten zurück, auf dessen eigener Höhe",
  ],
  [
    "flown by its pilot (mode {mode}): the pilot has to land it",
    "vom Piloten geflogen (Modus {mode}): Der Pilot muss sie landen",
  ],
  ["held: vehicle {other} is or may come below it", "gehalten: Drohne {other} ist oder kommt eventuell unter sie"],
  ["the mission is over", "die Mission ist beendet"],
  ["it has not arrived yet", "sie ist noch nicht angekommen"],
  [
    "its battery has not been reported for {silence} s, last at {battery}",
    "ihr Akku wurde seit {silence} s nicht gemeldet, zuletzt {battery}",
  ],
  [
    "battery at {battery}: the return takes {needed}, and {reserve} must be left",
    "Akku bei {battery}: Der Rückflug braucht {needed}, und {reserve} müssen bleiben",
  ],
  ["battery at {battery}", "Akku bei {battery}"],
  [
    "airborne, but its position is unknown or old: its distance to others is not monitored. Return it",
    "in der Luft, aber ihre Position ist unbekannt oder alt: Ihr Abstand zu anderen wird nicht überwacht. Zurückholen",
  ],
  [
    "only {distance} m from vehicle {other}, less than {allowed}",
    "nur {distance} m von Drohne {other} entfernt, weniger als {allowed}",
  ],
  ["the {limit} m allowed", "die erlaubten {limit} m"],
  [
    "{distance} m from vehicle {other}, ± {beside} m beside and ± {above} m above or below: that may be less than {allowed}",
    "{distance} m von Drohne {other} entfernt, ± {beside} m seitlich und ± {above} m in der Höhe: eventuell weniger als {allowed}",
  ],
  [
    "{beside} m beside and {above} m above or below vehicle {other}: {rest}",
    "{beside} m seitlich und {above} m in der Höhe von Drohne {other}: {rest}",
  ],
  ["neither can be held", "keine von beiden kann gehalten werden"],
  ["vehicle {id} is held", "Drohne {id} wird gehalten"],
  [
    "{height} m above the ground, below the floor of {floor} m. Return it, or take it over",
    "{height} m über Grund, unter der Mindesthöhe von {floor} m. Zurückholen oder übernehmen",
  ],
  ["above the floor above ground again", "wieder über der Mindesthöhe über Grund"],
  ["wrong altitude: {reason}. It leaves the swarm", "falsche Höhe: {reason}. Sie verlässt den Schwarm"],
  [
    "it flies {away} m {direction} the height that it reports, by {reference} and the others",
    "sie fliegt {away} m {direction} der gemeldeten Höhe, nach {reference} und den anderen",
  ],
  ["above", "über"],
  ["below", "unter"],
  ["its satellite receiver", "ihrem Satellitenempfänger"],
  ["its barometer", "ihrem Barometer"],
  [
    "{problem}. Others keep clear of it, and it leaves the swarm. Check its reception and corrections",
    "{problem}. Andere halten Abstand, und sie verlässt den Schwarm. Empfang und Korrekturdaten prüfen",
  ],
  ["its altitude is accurate enough again", "ihre Höhe ist wieder genau genug"],
  [
    "its altitude is accurate to ± {error} m only (95 %), {layers}",
    "ihre Höhe ist nur auf ± {error} m genau (95 %), {layers}",
  ],
  ["layers of {spacing} m allow ± {allowed} m", "Höhenebenen von {spacing} m erlauben ± {allowed} m"],
  [
    "it has lost its RTK fix, which layers of {spacing} m need",
    "sie hat die RTK-Ortung verloren, die Höhenebenen von {spacing} m brauchen",
  ],
  [
    "its estimator rejects the heights that it measures ({ratio} of what it accepts)",
    "ihre Lageschätzung verwirft die gemessenen Höhen ({ratio} des Zulässigen)",
  ],
  [
    "{problem}. It is held, and its distance to others is uncertain: return it, or land it",
    "{problem}. Sie wird gehalten, ihr Abstand zu anderen ist unsicher: zurückholen oder landen",
  ],
  [
    "{jump}. It is held, and others keep clear: check it, then resume it",
    "{jump}. Sie wird gehalten, und andere halten Abstand: prüfen, dann fortsetzen",
  ],
  ["its position jumped by {distance} m", "ihre Position ist um {distance} m gesprungen"],
  ["position consistent with velocity again", "Position passt wieder zur Geschwindigkeit"],
  ["it has lost its 3D position fix", "sie hat die 3D-Ortung verloren"],
  ["its estimator has no position", "ihre Lageschätzung hat keine Position"],
  [
    "its position deviates from its sensors ({ratio} of 1.0)",
    "ihre Position weicht von den Sensoren ab ({ratio} von 1.0)",
  ],
  ["its estimated position is good again", "ihre geschätzte Position ist wieder gut"],
  ["it has a 3D position fix again", "sie hat wieder eine 3D-Ortung"],
  ["its vibration is normal again", "ihre Vibration ist wieder normal"],
  ["its clock is steady again", "ihre Uhr läuft wieder stabil"],
  [
    "vibration of {level}: its altitude may be wrong. Return it, and check its propellers",
    "Vibration von {level}: Ihre Höhe kann falsch sein. Zurückholen und Propeller prüfen",
  ],
  [
    "its clock drifts by {drift} ms per second: the poses of its images may be wrong",
    "ihre Uhr weicht um {drift} ms pro Sekunde ab: Die Lagedaten ihrer Bilder können falsch sein",
  ],
  [
    "joins the swarm: it climbs to its layer at {height} m and flies there",
    "reiht sich ein: Sie steigt auf ihre Höhenebene bei {height} m und fliegt hin",
  ],
  ["has joined the swarm", "ist im Schwarm"],
  [
    "internal error, it is held: {error}. Return it, or land it",
    "interner Fehler, sie wird gehalten: {error}. Zurückholen oder landen",
  ],
  [
    "did not reach the swarm in time. Resume it to have it follow, or return it",
    "hat den Schwarm nicht rechtzeitig erreicht. Fortsetzen, damit sie folgt, oder zurückholen",
  ],
  ["taken up in the air, in its layer at {height} m", "in der Luft übernommen, in ihrer Höhenebene bei {height} m"],
  [
    "failsafe return height set to {height} m, its altitude layer, until it has landed",
    "Rückkehrhöhe der Notfunktion auf {height} m gesetzt, ihre Höhenebene, bis sie gelandet ist",
  ],
  ["failsafe return height restored", "Rückkehrhöhe der Notfunktion wiederhergestellt"],
  [
    "failsafe return height not restored ({error}). Set it by hand: {settings}",
    "Rückkehrhöhe der Notfunktion nicht wiederhergestellt ({error}). Von Hand setzen: {settings}",
  ],
  ["its link is lost", "ihr Funk ist verloren"],
  [
    "an earlier mission left its failsafe return height changed: this one restores {settings}",
    "eine frühere Mission hat ihre Rückkehrhöhe verändert hinterlassen: Diese stellt {settings} wieder her",
  ],
  [
    "Heights above the ground are not checked: the elevation model cannot be used{rest}",
    "Höhen über Grund werden nicht geprüft: Das Höhenmodell ist nicht verwendbar{rest}",
  ],
  [
    ". The altitude layers follow it: the vehicles cannot go on. Return or land them",
    ". Die Höhenebenen folgen ihm: Die Drohnen können nicht weiterfliegen. Zurückholen oder landen",
  ],
];
