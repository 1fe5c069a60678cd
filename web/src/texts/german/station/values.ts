/** German translations of why values, settings and proposals cannot be used. */
import type { StationText } from "../../station";

export const values: readonly StationText[] = [
  ["{name} must be {bounds}, but is {value}.", "{name} muss {bounds} sein, ist aber {value}."],
  ["above {least} and below {greatest}", "über {least} und unter {greatest}"],
  ["above {least} and at most {greatest}", "über {least} und höchstens {greatest}"],
  ["at least {least} and below {greatest}", "mindestens {least} und unter {greatest}"],
  ["at least {least} and at most {greatest}", "mindestens {least} und höchstens {greatest}"],
  ["above {bound}", "über {bound}"],
  ["at least {bound}", "mindestens {bound}"],
  ["below {bound}", "unter {bound}"],
  ["at most {bound}", "höchstens {bound}"],
  [
    "{name} must lie between min_factor and max_factor, but is {value}.",
    "{name} muss zwischen min_factor und max_factor liegen, ist aber {value}.",
  ],
  [
    "initial_c_s_hat * (1 + initial_c_c_hat) must be at most 1 (c_s + c_c <= c4), but is {value}.",
    "initial_c_s_hat * (1 + initial_c_c_hat) darf höchstens 1 sein (c_s + c_c <= c4), ist aber {value}.",
  ],
  [
    "min_factor must be below max_factor, but they are {least} and {greatest}.",
    "min_factor muss unter max_factor liegen, sie sind aber {least} und {greatest}.",
  ],
  [
    "body_height_m must be below canopy_height_m, {canopy}, but is {value}.",
    "body_height_m muss unter canopy_height_m liegen, {canopy}, ist aber {value}.",
  ],
  [
    "max_step_m must be at most long_step_m, {step}, but is {value}.",
    "max_step_m darf höchstens long_step_m sein, {step}, ist aber {value}.",
  ],
  [
    "min_distance_m must be at most view_spacing_m, {spacing}, but is {value}.",
    "min_distance_m darf höchstens view_spacing_m sein, {spacing}, ist aber {value}.",
  ],
  ["{strategy} has no parameter {name}; it has {names}.", "{strategy} hat keinen Parameter {name}; es gibt {names}."],
  [
    "The strategy {name} cannot be loaded ({reason}); install its package.",
    "Die Strategie {name} lässt sich nicht laden ({reason}); ihr Paket installieren.",
  ],
  [
    "There is no strategy {name}; choose one of {names}.",
    "Die Strategie {name} gibt es nicht; eine von {names} wählen.",
  ],
  [
    "{name} must be a finite number above 0, but is {value}.",
    "{name} muss eine endliche Zahl über 0 sein, ist aber {value}.",
  ],
  [
    "{name} must be above 0 and at most {greatest}, but is {value}.",
    "{name} muss über 0 und höchstens {greatest} sein, ist aber {value}.",
  ],
  ["files must name at least one file.", "files muss mindestens eine Datei nennen."],
  [
    "floor_above_ground_m ({floor}) must be below ceiling_above_ground_m ({ceiling}).",
    "floor_above_ground_m ({floor}) muss unter ceiling_above_ground_m ({ceiling}) liegen.",
  ],
  [
    "{name} must lie within {least} and {greatest}, but is {value}.",
    "{name} muss von {least} bis {greatest} sein, ist aber {value}.",
  ],
  [
    "passes must lie within 1 and {greatest}, but is {value}.",
    "passes muss von 1 bis {greatest} sein, ist aber {value}.",
  ],
  [
    "pod must lie within {least} and {greatest}, but is {value}.",
    "pod muss von {least} bis {greatest} sein, ist aber {value}.",
  ],
  [
    "forget_min must be a finite number above 0, or be left out for never, but is {value}.",
    "forget_min muss eine endliche Zahl über 0 sein oder für nie weggelassen werden, ist aber {value}.",
  ],
  ["below must be above 0 and at most 1, got {value}.", "below muss über 0 und höchstens 1 sein, ist aber {value}."],
  [
    "height_m must lie within {least} and {greatest}, below the cameras, but is {value}.",
    "Die Höhe muss zwischen {least} und {greatest} liegen, unter den Kameras, ist aber {value}.",
  ],
  [
    "speed must lie within {least} and {greatest}, but is {value}.",
    "Das Tempo muss zwischen {least} und {greatest} liegen, ist aber {value}.",
  ],
  [
    "No camera has the focal plane at a height of {height} m in front of it (the lowest camera is at {lowest} m): choose a plane below the cameras and point them towards the ground.",
    "Keine Kamera hat die Fokusebene in {height} m Höhe vor sich (die niedrigste Kamera ist auf {lowest} m): eine Ebene unter den Kameras wählen und diese auf den Boden richten.",
  ],
  ["Focusing needs at least two frames, got {count}.", "Fokussieren braucht mindestens zwei Bilder, es sind {count}."],
  [
    "The range of heights must be finite and ascending, got {least} to {greatest} m.",
    "Der Höhenbereich muss endlich und aufsteigend sein, ist aber {least} bis {greatest} m.",
  ],
  [
    "The focal height must be a finite number of metres, got {value}.",
    "Die Fokushöhe muss eine endliche Zahl in Metern sein, ist aber {value}.",
  ],
  [
    "Fewer than two cameras have the region to focus on in front of them at a height of {height} m: choose another region or range.",
    "Weniger als zwei Kameras haben den Bereich zum Fokussieren in {height} m Höhe vor sich: anderen Bereich oder andere Höhen wählen.",
  ],
  [
    "The region to focus on must span an area, got {left} to {right} and {bottom} to {top} {unit}.",
    "Der Bereich zum Fokussieren muss eine Fläche haben, ist aber {left} bis {right} und {bottom} bis {top} {unit}.",
  ],
  [
    "{feature} needs {library}, which is not installed: pip install 'aos-gcs[{extra}]'.",
    "{feature} braucht {library}, das nicht installiert ist: pip install 'aos-gcs[{extra}]'.",
  ],
  [
    "X-Seen: this is not a state of a mission. Send what GET /api/mission has returned in it.",
    "X-Seen: kein Stand einer Mission. Senden, was GET /api/mission darin geliefert hat.",
  ],
  ["{place}, {other} is no latitude and longitude.", "{place}, {other} ist keine Breite und Länge."],
  ["{place}, {other} is no latitude and longitude", "{place}, {other} ist keine Breite und Länge"],
  [
    "A proposal's {field} has more than {greatest} characters.",
    "{field} eines Vorschlags hat mehr als {greatest} Zeichen.",
  ],
  ["A proposal's times must be finite.", "Die Zeiten eines Vorschlags müssen endlich sein."],
  [
    "It has {count} points; {least} to {greatest} are possible.",
    "Er hat {count} Punkte; möglich sind {least} bis {greatest}.",
  ],
  ["it has {count} points; {greatest} at most are possible", "hat {count} Punkte; höchstens {greatest} sind möglich"],
  ["{name} {value} is no number", "{name} {value} ist keine Zahl"],
  ["a circle of {width} by {height} m", "ein Kreis von {width} mal {height} m"],
  ["a circle without a centre", "ein Kreis ohne Mittelpunkt"],
  ["a mark without a name: {value}", "eine Markierung ohne Namen: {value}"],
  ["a uid of {length} characters", "eine Kennung mit {length} Zeichen"],
  ["it has no place", "hat keinen Ort"],
  [
    "it was out of date when it came; compare the sender's clock with this machine's",
    "war bei der Ankunft veraltet; die Uhr des Senders mit der dieses Rechners vergleichen",
  ],
];
