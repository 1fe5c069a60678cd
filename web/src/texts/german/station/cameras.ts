/** German translations of why a camera has not delivered a usable image, and what is wrong with one. */
import type { StationText } from "../../station";

export const cameras: readonly StationText[] = [
  // Exposures.
  ["no answer", "keine Antwort"],
  ["the camera gives no orientation", "die Kamera nennt keine Ausrichtung"],
  ["the camera gives no position", "die Kamera nennt keine Position"],
  ["the camera reports that the exposure failed", "die Kamera meldet, dass die Aufnahme misslungen ist"],
  ["the autopilot reports that the exposure failed", "der Autopilot meldet, dass die Aufnahme misslungen ist"],
  [
    "it was exposed, but its pose and address did not arrive",
    "es wurde aufgenommen, aber Position, Ausrichtung und Adresse sind nicht angekommen",
  ],
  [
    "it was exposed, but the message with its pose and address did not arrive",
    "es wurde aufgenommen, aber die Meldung mit Position, Ausrichtung und Adresse ist nicht angekommen",
  ],
  [
    "no exposure was reported: check that the camera takes images automatically",
    "keine Aufnahme gemeldet: prüfen, ob die Kamera selbsttätig Bilder aufnimmt",
  ],
  ["no frame of the stream was exposed in time", "im Videostrom kam kein Bild rechtzeitig"],
  ["images come faster than they can be fetched", "Bilder kommen schneller, als sie abgeholt werden können"],
  ["the camera tells of no further image", "die Kamera meldet kein weiteres Bild"],
  ["vehicle {id} is already taking an image", "Drohne {id} nimmt schon ein Bild auf"],
  ["{stream} has no video", "{stream} enthält kein Video"],
  // Where and how it was taken.
  [
    "the vehicle has not reported its time: the pose of the frame is unknown",
    "die Drohne hat ihre Zeit nicht gemeldet: Position und Ausrichtung des Bildes sind nicht bekannt",
  ],
  ["the vehicle reports no {value}", "die Drohne meldet nichts zu: {value}"],
  [
    "no {value} of the vehicle near the time of exposure: its latest is {age} s older; the limit is {limit} s (max_pose_age_s)",
    "zur Zeit der Aufnahme fehlt von der Drohne: {value}; der letzte Wert ist {age} s älter, erlaubt sind {limit} s (max_pose_age_s)",
  ],
  [
    "no {value} of the vehicle near the time of exposure: there is a gap, or the frame is older than all; the limit is {limit} s (max_pose_age_s)",
    "zur Zeit der Aufnahme fehlt von der Drohne: {value}; da ist eine Lücke, oder das Bild ist älter als alle Werte, erlaubt sind {limit} s (max_pose_age_s)",
  ],
  [
    "its image was exposed {distance} m from where it is: it came more than {late} s late",
    "ihr Bild wurde {distance} m von ihrer jetzigen Position aufgenommen: Es kam mehr als {late} s zu spät",
  ],
  [
    "its time of exposure is known to ± {error} s, at {speed} m/s ± {distance} m; {limit} m are allowed: synchronise its clock, or fly slower",
    "die Zeit der Aufnahme ist auf ± {error} s bekannt, bei {speed} m/s ± {distance} m; erlaubt sind {limit} m: Uhr abgleichen oder langsamer fliegen",
  ],
  ["its position {position} is not on the earth", "seine Position {position} liegt nicht auf der Erde"],
  [
    "its position is {distance} m from where the vehicle was; the limit is {limit} m (max_pose_offset_m)",
    "seine Position ist {distance} m von der Drohne entfernt; erlaubt sind {limit} m (max_pose_offset_m)",
  ],
  ["its position is not known ({reason})", "seine Position ist nicht bekannt ({reason})"],
  ["its orientation is not known", "seine Ausrichtung ist nicht bekannt"],
  ["its orientation is not a rotation", "seine Ausrichtung ist keine Drehung"],
  ["its orientation is a reflection, not a rotation", "seine Ausrichtung ist eine Spiegelung, keine Drehung"],
  [
    "its orientation is not a rotation: the norm of its quaternion is {norm}",
    "seine Ausrichtung ist keine Drehung: Die Norm des Quaternions ist {norm}",
  ],
  [
    "it does not see the focal plane at a height of {height} m (its camera is at {camera} m): choose a plane below the cameras and point them towards the ground",
    "es zeigt die Fokusebene in {height} m Höhe nicht (seine Kamera ist in {camera} m): eine Ebene unter den Kameras wählen und sie auf den Boden richten",
  ],
  [
    "it was taken {age} s before it was requested, by its own time; the limit is {limit} s (match_tolerance_s)",
    "es wurde nach eigener Zeit {age} s vor der Anforderung aufgenommen; erlaubt sind {limit} s (match_tolerance_s)",
  ],
  // Lenses.
  [
    "the camera does not report its lens: set the option camera.fov_deg",
    "die Kamera meldet ihr Objektiv nicht: die Option camera.fov_deg setzen",
  ],
  [
    "its lens is not known, {reason}: set the option camera.fov_deg",
    "sein Objektiv ist nicht bekannt, {reason}: die Option camera.fov_deg setzen",
  ],
  ["its camera's intrinsics are not known", "die Abbildungsgrößen seiner Kamera sind nicht bekannt"],
  [
    "its camera's focal lengths are not positive ({x}, {y})",
    "die Brennweiten seiner Kamera sind nicht positiv ({x}, {y})",
  ],
  // Tags of photographs.
  ["its tags cannot be used: {reason}", "seine Metadaten sind nicht verwendbar: {reason}"],
  [
    "its tags contain no altitude (RelativeAltitude, AbsoluteAltitude or GPSAltitude)",
    "seine Metadaten enthalten keine Höhe (RelativeAltitude, AbsoluteAltitude oder GPSAltitude)",
  ],
  ["it has no GPSLatitude and GPSLongitude", "es hat weder GPSLatitude noch GPSLongitude"],
  [
    "it has no GimbalYawDegree and GimbalPitchDegree, nor another known attitude of the camera",
    "es hat weder GimbalYawDegree und GimbalPitchDegree noch eine andere bekannte Ausrichtung der Kamera",
  ],
  [
    "it has no CalibratedFocalLength of its own, FocalLengthIn35mmFilm or CameraHorizontalFOV, nor FocalLength with FocalPlaneXResolution",
    "es hat weder eine eigene CalibratedFocalLength noch FocalLengthIn35mmFilm oder CameraHorizontalFOV noch FocalLength mit FocalPlaneXResolution",
  ],
  [
    "its {names} are all 0: the gimbal has not reported its angles",
    "{names} sind alle 0: Der Gimbal hat seine Winkel nicht gemeldet",
  ],
  ["it is not a readable image", "es ist kein lesbares Bild"],
  [
    "its {tag}, {altitude} m, is not a plausible altitude of an aircraft",
    "{tag}, {altitude} m, ist keine plausible Höhe eines Fluggeräts",
  ],
  ["its Orientation tag, {tag}, says that it is mirrored", "nach der Angabe Orientation, {tag}, ist es gespiegelt"],
  [
    "its position, {latitude}, {longitude}, is not on the earth: it had no fix",
    "seine Position, {latitude}, {longitude}, liegt nicht auf der Erde: Es hatte keine Ortung",
  ],
  ["its XMP is nested too deeply", "seine XMP-Daten sind zu tief verschachtelt"],
  ["its XMP is not valid XML: {reason}", "seine XMP-Daten sind kein gültiges XML: {reason}"],
  // Files on their way.
  ["its file did not appear in time", "seine Datei ist nicht rechtzeitig erschienen"],
  ["its file was not decoded in time", "seine Datei wurde nicht rechtzeitig dekodiert"],
  [
    "the index of the image is not known, and its address needs it (url)",
    "die Nummer des Bildes ist nicht bekannt, seine Adresse braucht sie aber (url)",
  ],
  ["{file} is {age} s old: that of another flight", "{file} ist {age} s alt: von einem anderen Flug"],
  ["{address} answers with HTTP status {status}", "{address} antwortet mit HTTP-Status {status}"],
  ["{file} cannot be fetched whole: {reason}", "{file} kann nicht ganz abgeholt werden: {reason}"],
  ["{file} cannot be fetched: {reason}", "{file} kann nicht abgeholt werden: {reason}"],
  ["{file} did not arrive in time", "{file} ist nicht rechtzeitig angekommen"],
  [
    "{file} is compressed for the transfer: switch that off in the server",
    "{file} ist für die Übertragung komprimiert: im Server abschalten",
  ],
  ["{file} is larger than {limit} MiB (max_image_mib)", "{file} ist größer als {limit} MiB (max_image_mib)"],
  ["{file} was not decoded in time", "{file} wurde nicht rechtzeitig dekodiert"],
  [
    "its image of {size} bytes cannot be decoded: {reason}",
    "ihr Bild von {size} Byte kann nicht dekodiert werden: {reason}",
  ],
  [
    "the camera gives no address of its image: it has no file server",
    "die Kamera nennt keine Adresse ihres Bildes: Sie hat keinen Dateiserver",
  ],
  ["the image address {address} cannot be understood", "die Bildadresse {address} ist unverständlich"],
  ["the image address {address} is not http or https", "die Bildadresse {address} ist weder http noch https"],
  [
    "the image address {address} is not on the vehicle's own host {host}: {reason}",
    "die Bildadresse {address} liegt nicht auf dem eigenen Rechner der Drohne, {host}: {reason}",
  ],
  [
    "the image address {address} is on this machine and does not name a file of an image: {reason}",
    "die Bildadresse {address} liegt auf diesem Rechner und nennt keine Bilddatei: {reason}",
  ],
  [
    "vehicle {id} has no network address: write the host of its images into url",
    "Drohne {id} hat keine Netzadresse: den Rechner mit ihren Bildern in url eintragen",
  ],
  [
    "the listing has more than {count} images: move old ones away",
    "die Liste hat mehr als {count} Bilder: alte wegräumen",
  ],
  [
    "the listing is not a JSON list of names, or of objects with a name: {reason}",
    "die Liste ist keine JSON-Liste von Namen oder von Objekten mit Namen: {reason}",
  ],
  ["{name} is not the name of an image", "{name} ist kein Name eines Bildes"],
  [
    "{folder} holds more than {count} images: move old ones away",
    "{folder} enthält mehr als {count} Bilder: alte wegräumen",
  ],
  ["{file} is not a regular file", "{file} ist keine gewöhnliche Datei"],
  ["{file} is still being written", "{file} wird noch geschrieben"],
  ["{file} no longer exists", "{file} gibt es nicht mehr"],
  ["the folder {folder} cannot be read: {reason}", "der Ordner {folder} kann nicht gelesen werden: {reason}"],
  [
    "{count} new files ({names} …), {near} of them from within {window} s of the exposure: name them with the index (file_name), or expose less often",
    "{count} neue Dateien ({names} …), {near} davon innerhalb von {window} s um die Aufnahme: mit der Nummer benennen (file_name) oder seltener aufnehmen",
  ],
  // What is in them.
  [
    "an image with pages of {pages} is not understood: send RGB, grey, or RGB with thermal",
    "ein Bild mit Seiten von {pages} ist unverständlich: RGB, Grau oder RGB mit Wärmebild senden",
  ],
  ["the image file of {size} bytes cannot be decoded", "die Bilddatei von {size} Byte kann nicht dekodiert werden"],
  [
    "the image file of {size} bytes cannot be decoded: {reason}",
    "die Bilddatei von {size} Byte kann nicht dekodiert werden: {reason}",
  ],
  ["the image file of {size} bytes is incomplete", "die Bilddatei von {size} Byte ist unvollständig"],
  ["the image file of {size} bytes is not written yet", "die Bilddatei von {size} Byte ist noch nicht geschrieben"],
  [
    "the image file of {size} bytes is neither PNG, JPEG nor TIFF",
    "die Bilddatei von {size} Byte ist weder PNG noch JPEG noch TIFF",
  ],
  [
    "the image has {pixels} megapixels; the limit is {limit} (max_image_megapixels)",
    "das Bild hat {pixels} Megapixel; erlaubt sind {limit} (max_image_megapixels)",
  ],
  [
    "its pictures have {width} x {height} pixels; the limit is {limit} megapixels (max_image_megapixels)",
    "seine Bilder haben {width} × {height} Pixel; erlaubt sind {limit} Megapixel (max_image_megapixels)",
  ],
  ["page {page} of the TIFF file has no size", "Seite {page} der TIFF-Datei hat keine Größe"],
  ["the JPEG file has no frame header", "der JPEG-Datei fehlt der Bildkopf"],
  ["the JPEG file has no frame header where one must be", "der JPEG-Datei fehlt der Bildkopf an seiner Stelle"],
  [
    "the TIFF file gives a size twice, or not as one integer (tag {tag})",
    "die TIFF-Datei nennt eine Größe zweimal oder nicht als ganze Zahl (Feld {tag})",
  ],
  ["the TIFF file has more than {count} pages", "die TIFF-Datei hat mehr als {count} Seiten"],
];
