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
    "lower must be below upper, but they are {lower} and {upper}.",
    "lower muss unter upper liegen, sie sind aber {lower} und {upper}.",
  ],
  ["moves must be at least 1, but is {value}.", "moves muss mindestens 1 sein, ist aber {value}."],
  [
    "charges must be finite and at least 0, but are {value}.",
    "charges müssen endlich und mindestens 0 sein, sind aber {value}.",
  ],
  ["max_distance must be above 0, but is {value}.", "max_distance muss über 0 liegen, ist aber {value}."],
  [
    "steps of a schedule must be at least 1, but is {value}.",
    "Die Schritte eines Verlaufs müssen mindestens 1 sein, sind aber {value}.",
  ],
  [
    "{name} must be a finite number of at least 0, but is {value}.",
    "{name} muss eine endliche Zahl von mindestens 0 sein, ist aber {value}.",
  ],
  [
    "exponent must be a positive integer, but is {value}.",
    "exponent muss eine positive ganze Zahl sein, ist aber {value}.",
  ],
  [
    "{name} must be a finite number above 0, but is {value}.",
    "{name} muss eine endliche Zahl über 0 sein, ist aber {value}.",
  ],
  ["direction_enu must have a length above 0: {reason}.", "direction_enu muss eine Länge über 0 haben: {reason}."],
  ["n must be 1 or more vehicles, but is {value}.", "Es müssen 1 oder mehr Drohnen sein, sind aber {value}."],
  ["n must be 1 or more, but is {value}.", "Es müssen 1 oder mehr sein, sind aber {value}."],
  ["A pattern needs the spacings of line and legs.", "Ein Muster braucht die Abstände von Linie und Bahnen."],
  ["ground_enu_m must be finite positions in metres.", "ground_enu_m muss aus endlichen Orten in Metern bestehen."],
  [
    "{name} must be above 0 and at most {greatest}, but is {value}.",
    "{name} muss über 0 und höchstens {greatest} sein, ist aber {value}.",
  ],
  ["files must name at least one file.", "files muss mindestens eine Datei nennen."],
  [
    "floor_above_ground_m ({floor}) must be below ceiling_above_ground_m ({ceiling}).",
    "floor_above_ground_m ({floor}) muss unter ceiling_above_ground_m ({ceiling}) liegen.",
  ],
  ["{name} must be finite and above 0, got {value}.", "{name} muss endlich und über 0 sein, ist aber {value}."],
  ["{name} must lie within 0 and 1, got {value}.", "{name} muss zwischen 0 und 1 liegen, ist aber {value}."],
  [
    "The field of view must lie between 0 and 180 degrees, got {value}.",
    "Der Bildwinkel muss zwischen 0 und 180 Grad liegen, ist aber {value}.",
  ],
  [
    "altitude_m must be above the tree tops ({canopy} m), got {value}: fly higher.",
    "Die Flughöhe muss über den Baumkronen liegen ({canopy} m), ist aber {value}: höher fliegen.",
  ],
  [
    "altitude_m must be finite and above the occluders ({height} m), got {value}.",
    "Die Flughöhe muss endlich und über dem Bewuchs sein ({height} m), ist aber {value}.",
  ],
  [
    "crown_base_m must be at least 0 and below canopy_height_m ({canopy}), got {value}.",
    "crown_base_m muss mindestens 0 und unter canopy_height_m ({canopy}) sein, ist aber {value}.",
  ],
  ["drones must be 1 or more, got {value}.", "Es müssen 1 oder mehr Drohnen sein, sind aber {value}."],
  ["samples must be 1 or more, got {value}.", "samples muss 1 oder mehr sein, ist aber {value}."],
  [
    "saturation must be at least 0 and below 1, got {value}.",
    "saturation muss mindestens 0 und unter 1 sein, ist aber {value}.",
  ],
  ["{name} must not be negative, got {value}.", "{name} darf nicht negativ sein, ist aber {value}."],
  ["{name} must be at least {least}, got {value}.", "{name} muss mindestens {least} sein, ist aber {value}."],
  ["{name} must be positive, got {value}.", "{name} muss positiv sein, ist aber {value}."],
  ["plane_height_m must be finite, got {value}.", "plane_height_m muss endlich sein, ist aber {value}."],
  [
    "rate_hz must be above 0 and at most {greatest}, got {value}.",
    "rate_hz muss über 0 und höchstens {greatest} sein, ist aber {value}.",
  ],
  ["rx_quantile must lie within [0, 1), got {value}.", "rx_quantile muss in [0, 1) liegen, ist aber {value}."],
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
    "The range of offsets must be finite and ascending, got {least} to {greatest} m.",
    "Der Bereich der Versätze muss endlich und aufsteigend sein, ist aber {least} bis {greatest} m.",
  ],
  ["The region to focus on does not lie on the terrain.", "Der Bereich zum Fokussieren liegt nicht auf dem Gelände."],
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
    "A virtual camera has no distortion: give it an ideal one.",
    "Eine gedachte Kamera hat keine Verzeichnung: eine ideale angeben.",
  ],
  [
    "The focal plane z = {plane} m lies behind the virtual camera at z = {camera} m: choose a plane on the side that the camera looks to.",
    "Die Fokusebene z = {plane} m liegt hinter der gedachten Kamera bei z = {camera} m: eine Ebene in Blickrichtung wählen.",
  ],
  [
    "The focal plane z = {plane} m passes through the virtual camera: choose one in front of it.",
    "Die Fokusebene z = {plane} m geht durch die gedachte Kamera: eine davor wählen.",
  ],
  [
    "The virtual camera sees nothing of the terrain: check that the terrain lies in front of it, in the same world as the poses.",
    "Die gedachte Kamera sieht nichts vom Gelände: Es muss vor ihr liegen, in derselben Welt wie die Posen.",
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
