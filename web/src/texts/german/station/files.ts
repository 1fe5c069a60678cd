/** German translations of why files, recordings and pictures cannot be used. */
import type { StationText } from "../../station";

export const files: readonly StationText[] = [
  [
    "The heights of {file} are in {unit} ({factor}), not in metres: convert them, for example by gdal_calc, and state their datum.",
    "Die Höhen von {file} sind in {unit} ({factor}), nicht in Metern: umrechnen, etwa mit gdal_calc, und ihr Höhendatum angeben.",
  ],
  ["The geoid {file} does not exist; check the path.", "Das Geoid {file} gibt es nicht; Pfad prüfen."],
  [
    "The geoid {file} is not a grid file that PROJ can read.",
    "Das Geoid {file} ist keine Gitterdatei, die PROJ lesen kann.",
  ],
  [
    "{file} is in {one}, but {other} in {another}: warp them to one coordinate system (gdalwarp).",
    "{file} ist in {one}, aber {other} in {another}: in ein gemeinsames Koordinatensystem umrechnen (gdalwarp).",
  ],
  ["An elevation model needs at least one file.", "Ein Höhenmodell braucht mindestens eine Datei."],
  [
    "The elevation models {file} and {other} overlap and contradict each other by up to {amount} m; {limit} m are allowed. Leave out the wrong one, or correct its datum or unit.",
    "Die Höhenmodelle {file} und {other} überlappen sich und widersprechen einander um bis zu {amount} m; {limit} m sind zulässig. Das falsche weglassen, oder sein Höhendatum oder seine Einheit berichtigen.",
  ],
  [
    "The elevation model may have holes that are written as 0: {which} exactly 0 m, beside ground that is more than {step} m away from it, {where}. If data is missing there, declare it (gdal_edit -a_nodata 0); if a cliff falls to the sea there, the heights are right.",
    "Das Höhenmodell hat möglicherweise Löcher, die als 0 geschrieben sind: {which} genau 0 m hoch, neben Gelände, das mehr als {step} m davon entfernt ist, {where}. Fehlen dort Daten, sie als Löcher kennzeichnen (gdal_edit -a_nodata 0); fällt dort eine Klippe zum Meer ab, stimmen die Höhen.",
  ],
  ["{share} of the ground about this plan is", "{share} des Geländes um diesen Plan sind"],
  ["at {latitude}, {longitude} among others", "unter anderem bei {latitude}, {longitude}"],
  [
    "The cells of {file} and {other} do not lie on one grid: merge them to one file (gdalwarp).",
    "Die Zellen von {file} und {other} liegen nicht auf einem Gitter: zu einer Datei verbinden (gdalwarp).",
  ],
  [
    "The elevation model {file} does not state its vertical datum: give it (--datum egm96, egm2008, national or ellipsoid; datum in a configuration). Its provider's description contains it.",
    "Das Höhenmodell {file} nennt sein Höhendatum nicht: angeben (--datum egm96, egm2008, national oder ellipsoid; datum in der Konfiguration). Es steht in der Beschreibung des Anbieters.",
  ],
  [
    "The elevation model {file} lies off the earth, at latitudes from {south} to {north} and longitudes from {west} to {east} degrees: its coordinates are not those of {system}.",
    "Das Höhenmodell {file} liegt außerhalb der Erde, bei Breiten von {south} bis {north} und Längen von {west} bis {east} Grad: Seine Koordinaten sind nicht die von {system}.",
  ],
  ["The files state different vertical datums: {datums}.", "Die Dateien nennen verschiedene Höhendaten: {datums}."],
  [
    "The heights of {file} are above the ellipsoid, and no grid of the geoid, which relates it to mean sea level, is installed: the error would be up to 100 m. Install Debian's proj-data, or give PROJ's grid egm96_15 (--geoid FILE; geoid in a configuration).",
    "Die Höhen von {file} zählen vom Ellipsoid, und kein Gitter des Geoids, das es auf Meereshöhe bezieht, ist installiert: Der Fehler wäre bis zu 100 m. proj-data von Debian installieren oder das PROJ-Gitter egm96_15 angeben (--geoid FILE; geoid in der Konfiguration).",
  ],
  [
    "The vertical datum of {file} is {stated} ({code}) according to the file, not {given}.",
    "Das Höhendatum von {file} ist laut Datei {stated} ({code}), nicht {given}.",
  ],
  [
    "{file} has no places in a plane or in degrees: use one such as EPSG:31255.",
    "{file} hat keine Orte in einer Ebene oder in Grad: ein Koordinatensystem wie EPSG:31255 verwenden.",
  ],
  [
    "{file} is in {stated} according to the file, not in {given}: leave --crs out.",
    "{file} ist laut Datei in {stated}, nicht in {given}: --crs weglassen.",
  ],
  [
    "The coordinate system {system} is not known: use one such as EPSG:31255.",
    "Das Koordinatensystem {system} ist unbekannt: eines wie EPSG:31255 verwenden.",
  ],
  [
    "The coordinate system of {file} is not known: use one such as EPSG:31255.",
    "Das Koordinatensystem von {file} ist unbekannt: eines wie EPSG:31255 verwenden.",
  ],
  ["The elevation model {file} cannot be read: {reason}.", "Das Höhenmodell {file} ist nicht lesbar: {reason}."],
  [
    "{file} has heights of {height} m: declare them as holes (gdal_edit -a_nodata {value}).",
    "{file} hat Höhen von {height} m: als Lücken kennzeichnen (gdal_edit -a_nodata {value}).",
  ],
  [
    "{file} has heights of {height}: no place on earth is so high. Are they in feet? Convert them to metres.",
    "{file} hat Höhen von {height}: So hoch ist kein Ort der Erde. Sind sie in Fuß? In Meter umrechnen.",
  ],
  [
    "The elevation model {file} is stored in blocks of {rows} x {columns} heights, {size} MB each, which are read as a whole: store it in tiles (gdal_translate -co TILED=YES IN OUT).",
    "Das Höhenmodell {file} ist in Blöcken von {rows} x {columns} Höhen zu {size} MB gespeichert, die als Ganzes gelesen werden: in Kacheln speichern (gdal_translate -co TILED=YES IN OUT).",
  ],
  [
    "{file} cannot be read: its name is not UTF-8. Rename it.",
    "{file} ist nicht lesbar: Der Name ist nicht UTF-8. Umbenennen.",
  ],
  ["{file} does not exist; check the path.", "{file} gibt es nicht; Pfad prüfen."],
  [
    "{file} has {bands} bands: extract the one with the heights (gdal_translate -b 1 IN OUT).",
    "{file} hat {bands} Kanäle: den mit den Höhen herauslösen (gdal_translate -b 1 IN OUT).",
  ],
  ["{file} has complex numbers, which are not heights.", "{file} hat komplexe Zahlen, keine Höhen."],
  [
    "{file} has no cells of a finite size: its place is not known.",
    "{file} hat keine Zellen endlicher Größe: Sein Ort ist unbekannt.",
  ],
  [
    "{file} is a picture ({bands} bands of {type}), not heights.",
    "{file} ist ein Bild ({bands} Kanäle vom Typ {type}), keine Höhen.",
  ],
  [
    "{file} is incomplete: it is too small for {rows} x {columns} heights.",
    "{file} ist unvollständig: zu klein für {rows} x {columns} Höhen.",
  ],
  [
    "{file} states the scale {scale} and the offset {offset}, which are invalid.",
    "{file} nennt den Maßstab {scale} und den Versatz {offset}, die ungültig sind.",
  ],
  [
    "The heights of {file} are in {unit}, not in metres: convert them.",
    "Die Höhen von {file} sind in {unit}, nicht in Metern: umrechnen.",
  ],
  [
    "{model}: the elevation model has no heights about the mission.",
    "{model}: Das Höhenmodell hat um die Mission herum keine Höhen.",
  ],
  ["{model}: the ground below the mission is not known.", "{model}: Der Boden unter der Mission ist unbekannt."],
  [
    "The ground below a plan is known by an elevation model and an origin only.",
    "Der Boden unter einem Plan ist nur mit Höhenmodell und Ursprung bekannt.",
  ],
  [
    "mission.origin_deg and the search area are needed to know the ground below them.",
    "Für den Boden darunter braucht es mission.origin_deg und das Suchgebiet.",
  ],
  [
    "The prior {file} does not meet the search area, or is 0 everywhere in it: check its coordinate system, move the area, or search without a prior (search.prior).",
    "Das Vorwissen {file} trifft das Suchgebiet nicht oder ist darin überall 0: Koordinatensystem prüfen, Gebiet verschieben oder ohne Vorwissen suchen (search.prior).",
  ],
  [
    "The prior {file} must be a GeoTIFF (.tif) or a GeoJSON file (.geojson).",
    "Das Vorwissen {file} muss ein GeoTIFF (.tif) oder eine GeoJSON-Datei (.geojson) sein.",
  ],
  [
    "{file} is in {system}, which has no places in a plane or in degrees: warp it.",
    "{file} ist in {system}, ohne Orte in einer Ebene oder in Grad: umrechnen (gdalwarp).",
  ],
  [
    "Every value of the probability map {file} is 0: it says nothing of where the person is.",
    "Jeder Wert der Wahrscheinlichkeitskarte {file} ist 0: Sie sagt nichts darüber, wo die Person ist.",
  ],
  [
    "The coordinate system of {file} is not known: warp it to one such as EPSG:4326.",
    "Das Koordinatensystem von {file} ist unbekannt: in eines wie EPSG:4326 umrechnen.",
  ],
  [
    "The place of {file} is not on the Earth: state its coordinate system correctly.",
    "Der Ort von {file} liegt nicht auf der Erde: Koordinatensystem richtig angeben.",
  ],
  [
    "The probability map {file} cannot be read: {reason}.",
    "Die Wahrscheinlichkeitskarte {file} ist nicht lesbar: {reason}.",
  ],
  [
    "The probability map {file} has {bands} bands or colours: export the values as one band.",
    "Die Wahrscheinlichkeitskarte {file} hat {bands} Kanäle oder Farben: Werte als einen Kanal exportieren.",
  ],
  [
    "The probability map {file} has {count} cells that are no finite number: declare them as nodata, or set them to 0.",
    "Die Wahrscheinlichkeitskarte {file} hat {count} Zellen ohne endliche Zahl: als nodata kennzeichnen oder auf 0 setzen.",
  ],
  [
    "The probability map {file} has {rows} x {columns} cells, {greatest} are allowed: cut it, or make its cells larger (gdalwarp -te, -tr).",
    "Die Wahrscheinlichkeitskarte {file} hat {rows} x {columns} Zellen, {greatest} sind erlaubt: zuschneiden oder Zellen vergrößern (gdalwarp -te, -tr).",
  ],
  [
    "The probability map {file} has complex numbers: export real ones.",
    "Die Wahrscheinlichkeitskarte {file} hat komplexe Zahlen: reelle exportieren.",
  ],
  [
    "The probability map {file} has negative values, down to {least}: set them to 0, or declare them as nodata.",
    "Die Wahrscheinlichkeitskarte {file} hat negative Werte bis {least}: auf 0 setzen oder als nodata kennzeichnen.",
  ],
  [
    "The probability map {file} is a picture whose place is not known: georeference it.",
    "Die Wahrscheinlichkeitskarte {file} ist ein Bild ohne Ort: georeferenzieren.",
  ],
  [
    "The probability map {file} states no coordinate system: set it (gdal_edit.py -a_srs EPSG:CODE {name}).",
    "Die Wahrscheinlichkeitskarte {file} nennt kein Koordinatensystem: setzen (gdal_edit.py -a_srs EPSG:CODE {name}).",
  ],
  [
    "{file} holds {count} features: name 1 to {greatest} segments.",
    "{file} enthält {count} Objekte: 1 bis {greatest} Abschnitte nennen.",
  ],
  ["{file} holds a {kind}: a segment is one polygon.", "{file} enthält {kind}: Ein Abschnitt ist ein Polygon."],
  [
    "{file} holds a polygon with holes: draw segments without holes.",
    "{file} enthält ein Polygon mit Löchern: Abschnitte ohne Löcher zeichnen.",
  ],
  [
    "{file} holds a segment of {corners} corners, {greatest} at most: simplify it.",
    "{file} enthält einen Abschnitt mit {corners} Ecken, höchstens {greatest}: vereinfachen.",
  ],
  [
    "{file}: feature {number} needs a name of 1 to {greatest} characters (property name or title), but has {value}.",
    "{file}: Objekt {number} braucht einen Namen mit 1 bis {greatest} Zeichen (Eigenschaft name oder title), hat aber {value}.",
  ],
  [
    "{file}: two segments are named {name}: name them differently.",
    "{file}: Zwei Abschnitte heißen {name}: verschieden benennen.",
  ],
  [
    "The segments {file} must be a GeoJSON file (.geojson).",
    "Die Abschnitte {file} müssen eine GeoJSON-Datei (.geojson) sein.",
  ],
  ["{file} cannot be read: {reason}.", "{file} ist nicht lesbar: {reason}."],
  ["{file} holds {value} among its features.", "{file} enthält {value} unter seinen Objekten."],
  [
    "{file} holds {count} points: leave one last known point.",
    "{file} enthält {count} Punkte: einen letzten bekannten Ort übrig lassen.",
  ],
  ["{file} holds a feature without a geometry: remove it.", "{file} enthält ein Objekt ohne Geometrie: entfernen."],
  [
    "{file} holds a place that is no pair of numbers: {value}.",
    "{file} enthält einen Ort, der kein Zahlenpaar ist: {value}.",
  ],
  [
    "{file} holds a polygon without an area: remove it, or draw it again.",
    "{file} enthält ein Polygon ohne Fläche: entfernen oder neu zeichnen.",
  ],
  ["{file} holds a polygon without coordinates: remove it.", "{file} enthält ein Polygon ohne Koordinaten: entfernen."],
  [
    "{file} holds a ring of {corners} corners: a polygon has 3 or more.",
    "{file} enthält einen Ring mit {corners} Ecken: Ein Polygon hat 3 oder mehr.",
  ],
  [
    "{file} holds a ring that is no list of places: {value}.",
    "{file} enthält einen Ring, der keine Liste von Orten ist: {value}.",
  ],
  [
    "{file} holds no feature: draw polygons with a probability, or a last known point.",
    "{file} enthält kein Objekt: Polygone mit Wahrscheinlichkeit oder einen letzten bekannten Ort zeichnen.",
  ],
  [
    "{file} holds the geometries {kinds}: give either polygons, or one last known point.",
    "{file} enthält die Geometrien {kinds}: entweder Polygone oder einen letzten bekannten Ort angeben.",
  ],
  [
    "{file} holds the place {place}, which is no longitude and latitude: save it as EPSG:4326.",
    "{file} enthält den Ort {place}, der keine Länge und Breite ist: als EPSG:4326 speichern.",
  ],
  [
    "{file} is in the coordinate system {system}: GeoJSON is in longitude and latitude (WGS 84); save it as EPSG:4326.",
    "{file} ist im Koordinatensystem {system}: GeoJSON ist in Länge und Breite (WGS 84); als EPSG:4326 speichern.",
  ],
  ["{file} is larger than {size} MB: simplify it.", "{file} ist größer als {size} MB: vereinfachen."],
  [
    "{file} is no GeoJSON with features: its type is {type}.",
    "{file} ist kein GeoJSON mit Objekten: Sein Typ ist {type}.",
  ],
  ["{file} is no GeoJSON: its text is not an object.", "{file} ist kein GeoJSON: Sein Text ist kein Objekt."],
  ["{file} is not valid JSON: {reason}.", "{file} ist kein gültiges JSON: {reason}."],
  [
    "{name} must be 0 to 1, but is {value}: state a share of 1, or weight instead.",
    "{name} muss 0 bis 1 sein, ist aber {value}: einen Anteil an 1 angeben, oder stattdessen weight.",
  ],
  [
    "{name} must not be negative, but is {value}: state 0 where the person cannot be.",
    "{name} darf nicht negativ sein, ist aber {value}: 0 angeben, wo die Person nicht sein kann.",
  ],
  [
    "{file} states probability for some polygons and weight for others: use one of them.",
    "{file} gibt für manche Polygone probability an, für andere weight: nur eines verwenden.",
  ],
  [
    "{file}: distances_m must be four ascending numbers of metres above 0 ({shares}), but is {value}.",
    "{file}: distances_m muss aus vier aufsteigenden Zahlen in Metern über 0 bestehen ({shares}), ist aber {value}.",
  ],
  [
    "{file}: every {field} is 0: state where the person is likely to be.",
    "{file}: Jedes {field} ist 0: angeben, wo die Person wahrscheinlich ist.",
  ],
  [
    "{file}: feature {number} has neither probability (0 to 1) nor weight among its properties: state one of them for each polygon.",
    "{file}: Objekt {number} hat weder probability (0 bis 1) noch weight: für jedes Polygon eines angeben.",
  ],
  [
    "{file}: the last known point needs the property distances_m, the four distances in metres within which {shares} of lost persons of the category are found, but it is {value}.",
    "{file}: Der letzte bekannte Ort braucht die Eigenschaft distances_m, die vier Entfernungen in Metern, innerhalb derer {shares} der Vermissten dieser Gruppe gefunden werden, sie ist aber {value}.",
  ],
  [
    "{file}: the polygons have more than {greatest} corners: simplify them.",
    "{file}: Die Polygone haben mehr als {greatest} Ecken: vereinfachen.",
  ],
  [
    "{file}: the probabilities of the polygons add up to {sum}, 1 at most: state them as shares of 1, or as weight.",
    "{file}: Die Wahrscheinlichkeiten der Polygone ergeben zusammen {sum}, höchstens 1: als Anteile an 1 angeben, oder als weight.",
  ],
  [
    "The map of searched ground has no tile: nothing was searched.",
    "Die Karte des abgesuchten Bodens ist leer: Nichts wurde abgesucht.",
  ],
  [
    "The probability of detection is not known: the mission's configuration has no section [forest].",
    "Die Entdeckungswahrscheinlichkeit ist unbekannt: Der Konfiguration der Mission fehlt der Abschnitt [forest].",
  ],
  [
    "{folder} holds no map of searched ground: nothing was searched yet, or it is the record of an older version or a survey.",
    "{folder} enthält keine Karte des abgesuchten Bodens: Noch wurde nichts abgesucht, oder es ist die Aufzeichnung einer älteren Version oder einer Bildauswertung.",
  ],
  ["{folder} holds no frames of step {step}", "{folder} enthält keine Bilder von Schritt {step}"],
  ["kind: the frame of vehicle {id} has no {band} band.", "Das Bild der Drohne {id} hat keinen Kanal {band}."],
  ["kind: the frames of step {step} have no {band} band.", "Die Bilder von Schritt {step} haben keinen Kanal {band}."],
  ["vehicle_id: step {step} has no frame of vehicle {id}.", "Schritt {step} hat kein Bild der Drohne {id}."],
  ["A video has {greatest} tiles at most, not {count}.", "Ein Video hat höchstens {greatest} Kacheln, nicht {count}."],
  [
    "This build of the library av has none of the encoders {names}.",
    "Diese Ausgabe der Bibliothek av hat keinen der Kodierer {names}.",
  ],
  [
    "a raster of the mission is damaged; the next step makes another one",
    "Ein Raster der Mission ist beschädigt; der nächste Schritt macht ein neues",
  ],
  ["the frame has no {band} band; it has {bands}", "Das Bild hat keinen Kanal {band}, nur {bands}"],
  [
    "large: only a single tile can be watched in this size",
    "In dieser Größe lässt sich nur eine einzelne Kachel zeigen",
  ],
  [
    "tiles: at most {greatest} can be watched at a time, not {count}",
    "Höchstens {greatest} Kacheln lassen sich zugleich zeigen, nicht {count}",
  ],
  ["tiles: {reason}", "Kacheln: {reason}"],
  [
    "{folder} holds no state of the mission to hand over: it ended before it began",
    "{folder} enthält keinen Stand der Mission zum Übergeben: Sie endete, bevor sie begann",
  ],
  ["a picture of a finding is damaged: {reason}", "Ein Bild eines Fundes ist beschädigt: {reason}"],
  [
    "the recorded picture {name} of the searched ground is damaged",
    "Das aufgezeichnete Bild {name} des abgesuchten Bodens ist beschädigt",
  ],
  [
    "time_zone: {zone} is not known here; name one as in Europe/Vienna, or UTC.",
    "Die Zeitzone {zone} ist hier unbekannt; eine wie Europe/Vienna nennen, oder UTC.",
  ],
  [
    "time_zone: {zone} … (shortened from {length} characters) is not known here; name one as in Europe/Vienna, or UTC.",
    "Die Zeitzone {zone} … (gekürzt von {length} Zeichen) ist hier unbekannt; eine wie Europe/Vienna nennen, oder UTC.",
  ],
  [
    "{folder} contains no snapshot of the mission; it ended before it began",
    "{folder} enthält keinen Stand der Mission; sie endete, bevor sie begann",
  ],
  ["event {number} of {folder} is not a snapshot", "Ereignis {number} von {folder} ist kein Stand der Mission"],
  ["cannot read {file}: {reason}", "{file} ist nicht lesbar: {reason}"],
  ["it is not a JSON object", "kein JSON-Objekt"],
];
