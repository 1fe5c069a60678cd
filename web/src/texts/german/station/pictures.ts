/** German translations of why images cannot be analysed or shown together, and which values of it are impossible. */
import type { StationText } from "../../station";

export const pictures: readonly StationText[] = [
  ["The camera of vehicle {id} is below the ground.", "Die Kamera der Drohne {id} ist unter dem Boden."],
  ["The frame of vehicle {id} shows nothing of the ground.", "Das Bild der Drohne {id} zeigt nichts vom Boden."],
  [
    "The frame of vehicle {id} shows the ground too flat, or not at all.",
    "Das Bild der Drohne {id} zeigt den Boden zu flach oder gar nicht.",
  ],
  [
    "its band thermal holds temperatures, others have grey levels: have all cameras deliver one",
    "sein Kanal thermal enthält Temperaturen, andere haben Grauwerte: alle Kameras auf das Gleiche einstellen",
  ],
  [
    "its band thermal holds grey levels, others have temperatures: have all cameras deliver one",
    "sein Kanal thermal enthält Grauwerte, andere haben Temperaturen: alle Kameras auf das Gleiche einstellen",
  ],
  ["No frame can be used ({reasons}).", "Kein Bild ist verwendbar ({reasons})."],
  ["There is no frame to analyse: give at least one.", "Kein Bild zum Auswerten: mindestens eines angeben."],
  ["There is no frame to integrate: give at least one.", "Kein Bild für das Integral: mindestens eines angeben."],
  [
    "The frame of vehicle {id} has the bands {bands}, others have {others}: only frames with the same bands can be integrated.",
    "Das Bild der Drohne {id} hat die Kanäle {bands}, andere haben {others}: Nur Bilder mit gleichen Kanälen ergeben ein Integral.",
  ],
  ["The frame of vehicle {id} is not part of the integral.", "Das Bild der Drohne {id} gehört nicht zum Integral."],
  [
    "The image of vehicle {id} has shape {shape}, but its camera and bands ask for {wanted}.",
    "Das Bild der Drohne {id} hat die Form {shape}, ihre Kamera und die Kanäle verlangen {wanted}.",
  ],
  [
    "The thermal detector needs a thermal band, but the frames have {bands}: choose another imaging.detector.",
    "Die Auswertung nach Wärme braucht einen Wärmekanal, die Bilder haben {bands}: imaging.detector ändern.",
  ],
  [
    "Warm bodies need a band 'thermal', but the frame has {bands}.",
    "Warme Körper brauchen einen Wärmekanal, das Bild hat {bands}.",
  ],
  [
    "Registration takes one frame per vehicle: leave the older ones out.",
    "Die Ausrichtung der Bilder nimmt ein Bild je Drohne: die älteren weglassen.",
  ],
  [
    "A map of {width} m x {height} m at {resolution} m has {columns} x {rows} cells, more than {limit}: choose a coarser resolution.",
    "Eine Karte von {width} m × {height} m bei {resolution} m hat {columns} × {rows} Zellen, mehr als {limit}: eine gröbere Auflösung wählen.",
  ],
  [
    "No image covers any cell of the map: check the focal surface and the poses.",
    "Kein Bild deckt eine Zelle der Karte: Fokusfläche, Positionen und Ausrichtungen prüfen.",
  ],
  [
    "No image has the focal surface in front of its camera: check its height, and that it is given in the world of the poses.",
    "Bei keinem Bild liegt die Fokusfläche vor der Kamera: ihre Höhe prüfen, und ob sie im Koordinatensystem der Positionen angegeben ist.",
  ],
  [
    "No image sees the terrain: check that it lies below the flight, in the world of the poses.",
    "Kein Bild zeigt das Gelände: prüfen, ob es unter dem Flug liegt, im Koordinatensystem der Positionen.",
  ],
  [
    "A virtual camera has no distortion: give it an ideal one.",
    "Eine virtuelle Kamera verzeichnet nicht: eine ideale angeben.",
  ],
  [
    "The focal plane z = {plane} m lies behind the virtual camera at z = {camera} m: choose a plane on the side that the camera looks to.",
    "Die Fokusebene z = {plane} m liegt hinter der virtuellen Kamera bei z = {camera} m: eine Ebene in Blickrichtung wählen.",
  ],
  [
    "The focal plane z = {plane} m passes through the virtual camera: choose one in front of it.",
    "Die Fokusebene z = {plane} m geht durch die virtuelle Kamera: eine davor wählen.",
  ],
  [
    "The virtual camera sees nothing of the terrain: check that the terrain lies in front of it, in the same world as the poses.",
    "Die virtuelle Kamera sieht nichts vom Gelände: prüfen, ob es vor ihr liegt, im Koordinatensystem der Positionen.",
  ],
  [
    "There is no view of the target to locate it from.",
    "Das Ziel ist auf keinem Bild, aus dem es geortet werden kann.",
  ],
  // Values.
  ["{name} must be finite and above 0, got {value}.", "{name} muss endlich und größer als 0 sein, ist aber {value}."],
  ["{name} must lie within 0 and 1, got {value}.", "{name} muss von 0 bis 1 sein, ist aber {value}."],
  [
    "{name} must be a finite number not below 0, but is {value}.",
    "{name} muss endlich und mindestens 0 sein, ist aber {value}.",
  ],
  [
    "The field of view must lie between 0 and 180 degrees, got {value}.",
    "Das Sichtfeld muss zwischen 0 und 180 Grad sein, ist aber {value}.",
  ],
  [
    "altitude_m must be above the tree tops ({tops} m), got {value}: fly higher.",
    "altitude_m muss über den Baumwipfeln sein ({tops} m), ist aber {value}: höher fliegen.",
  ],
  [
    "altitude_m must be finite and above the occluders ({tops} m), got {value}.",
    "altitude_m muss endlich und über den Hindernissen sein ({tops} m), ist aber {value}.",
  ],
  [
    "crown_base_m must be at least 0 and below canopy_height_m ({height}), got {value}.",
    "crown_base_m muss mindestens 0 und kleiner als canopy_height_m sein ({height}), ist aber {value}.",
  ],
  [
    "A mission has 1 to {most} drones, got {value}: give another number, or a lower saturation.",
    "Eine Mission hat 1 bis {most} Drohnen, nicht {value}: eine andere Zahl oder eine kleinere Sättigung angeben.",
  ],
  ["samples must be 1 or more, got {value}.", "samples muss mindestens 1 sein, ist aber {value}."],
  [
    "saturation must be at least 0 and below 1, got {value}.",
    "saturation muss mindestens 0 und kleiner als 1 sein, ist aber {value}.",
  ],
  [
    "persistent_share must lie within 0 and 1, but is {value}.",
    "persistent_share muss von 0 bis 1 sein, ist aber {value}.",
  ],
  [
    "target_extent_m must be above 0: no target is a point.",
    "target_extent_m muss größer als 0 sein: Kein Ziel ist ein Punkt.",
  ],
  [
    "confirm_hits must lie within 1 and confirm_window ({window}), but is {value}.",
    "confirm_hits muss von 1 bis confirm_window ({window}) sein, ist aber {value}.",
  ],
  ["direction_enu must have a length above 0: {value}.", "direction_enu muss eine Länge über 0 haben: {value}."],
  ["n must be 1 or more vehicles, but is {value}.", "n muss mindestens 1 Drohne sein, ist aber {value}."],
  ["n must be 1 or more, but is {value}.", "n muss mindestens 1 sein, ist aber {value}."],
  ["A pattern needs the spacings of line and legs.", "Ein Muster braucht die Abstände von Linie und Bahnen."],
  ["ground_enu_m must be finite positions in metres.", "ground_enu_m muss endliche Positionen in Metern enthalten."],
  [
    "Vehicle {id} cannot change from the task {from} to {to}.",
    "Drohne {id} kann nicht von der Aufgabe {from} zu {to} wechseln.",
  ],
];
