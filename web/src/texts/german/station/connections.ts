/** German translations of what is wrong with connections: to vehicles, to receivers of live sharing, and to TAK. */
import type { StationText } from "../../station";

export const connections: readonly StationText[] = [
  // Links and serial ports.
  ["{port} cannot be opened: {reason}", "{port} kann nicht geöffnet werden: {reason}"],
  ["{address} does not respond: check address and network", "{address} antwortet nicht: Adresse und Netz prüfen"],
  [
    "port {port} is in use: stop the other ground station or choose another port ({link})",
    "Port {port} ist belegt: die andere Bodenstation beenden oder einen anderen Port wählen ({link})",
  ],
  [
    "{port} does not exist: connect the radio, or find its name in /dev/serial/by-id",
    "{port} gibt es nicht: Funkgerät anschließen oder seinen Namen in /dev/serial/by-id suchen",
  ],
  ["{port} is in use: stop the other ground station", "{port} ist belegt: die andere Bodenstation beenden"],
  [
    "no permission to open {port}: add your user to its group (often dialout) and log in again",
    "keine Berechtigung für {port}: den Benutzer in die Gruppe des Geräts aufnehmen (oft dialout) und neu anmelden",
  ],
  [
    "{file} cannot be written: {reason}; choose another log folder",
    "{file} kann nicht geschrieben werden: {reason}; einen anderen Protokollordner wählen",
  ],
  // The page's own port.
  ["cannot listen on {host} port {port}: {reason}", "{host}, Port {port}, kann nicht geöffnet werden: {reason}"],
  [
    "port {port} is in use by {program} or choose another port with --port",
    "Port {port} ist belegt durch {program} oder mit --port einen anderen wählen",
  ],
  [
    "port {port} is in use: stop the other program or choose another port with --port",
    "Port {port} ist belegt: das andere Programm beenden oder mit --port einen anderen wählen",
  ],
  [
    "The header X-Seen is missing: it names the state of the mission by which you command. Send what GET /api/mission has returned in it.",
    "Die Kopfzeile X-Seen fehlt: Sie nennt den Stand der Mission, nach dem Sie befehlen. Darin senden, was GET /api/mission geliefert hat.",
  ],
  // Services of others.
  [
    "No answer within {limit} s; check the address and the network.",
    "Keine Antwort in {limit} s; Adresse und Netz prüfen.",
  ],
  ["No connection to the service ({reason}).", "Keine Verbindung zum Dienst ({reason})."],
  [
    "The name of the service is not known; check it, or the network.",
    "Der Name des Dienstes ist nicht bekannt; ihn oder das Netz prüfen.",
  ],
  ["The service answers with status {status}.", "Der Dienst antwortet mit Status {status}."],
  ["The service has moved ({status}); {remedy}.", "Der Dienst ist umgezogen ({status}); {remedy}."],
  ["The service refuses us ({status}); {remedy}.", "Der Dienst weist diese Station ab ({status}); {remedy}."],
  ["The service's answer is larger than {limit} MiB.", "Die Antwort des Dienstes ist größer als {limit} MiB."],
  [
    "The service's certificate cannot be verified ({reason}).",
    "Das Zertifikat des Dienstes kann nicht geprüft werden ({reason}).",
  ],
  ["The service has not named the object that it made.", "Der Dienst hat das angelegte Objekt nicht genannt."],
  [
    "The service's clock differs from this machine's by {difference} min: set the clock.",
    "Die Uhr des Dienstes weicht um {difference} min von der dieses Rechners ab: Uhr stellen.",
  ],
  // TAK servers.
  [
    "The name of the server is not known; check it, or the network.",
    "Der Name des Servers ist nicht bekannt; ihn oder das Netz prüfen.",
  ],
  [
    "The server does not speak TLS as expected ({reason}); check the port.",
    "Der Server spricht nicht TLS wie erwartet ({reason}); Port prüfen.",
  ],
  [
    "The server has closed the connection without a word; check that it accepts our certificate.",
    "Der Server hat die Verbindung ohne Meldung geschlossen; prüfen, ob er das Zertifikat dieser Station annimmt.",
  ],
  ["The server has closed the connection.", "Der Server hat die Verbindung geschlossen."],
  [
    "The server has taken nothing for {silence} s; it is overloaded, or stands still.",
    "Der Server hat seit {silence} s nichts angenommen; er ist überlastet oder steht.",
  ],
  [
    "The server refuses our certificate; check that it knows it.",
    "Der Server lehnt das Zertifikat dieser Station ab; prüfen, ob er es kennt.",
  ],
  [
    "The server refuses the connection; check the port, or start the server.",
    "Der Server lehnt die Verbindung ab; Port prüfen oder den Server starten.",
  ],
  [
    "The server's certificate has expired, or this machine's clock is wrong.",
    "Das Zertifikat des Servers ist abgelaufen, oder die Uhr dieses Rechners geht falsch.",
  ],
  [
    "The server's certificate is for another name ({reason}). Set tak.server_name to the name in it, if that is the server of your team.",
    "Das Zertifikat des Servers gilt für einen anderen Namen ({reason}). tak.server_name auf den Namen im Zertifikat setzen, falls das der Server des Teams ist.",
  ],
  [
    "The server's certificate is not signed by the authority that we trust ({reason}).",
    "Das Zertifikat des Servers ist nicht von der vertrauten Stelle unterschrieben ({reason}).",
  ],
  [
    "The server's certificate is not valid yet: check this machine's clock.",
    "Das Zertifikat des Servers gilt noch nicht: Uhr dieses Rechners prüfen.",
  ],
  ["{name} {value} is no time", "{name} {value} ist keine Zeit"],
  ["XML that is no event", "XML, das kein Ereignis ist"],
  ["an event of more than {limit} KiB", "ein Ereignis von mehr als {limit} KiB"],
  [
    "an event that declares a document type or entities",
    "ein Ereignis, das einen Dokumenttyp oder Entitäten vereinbart",
  ],
  ["an event that is no XML", "ein Ereignis, das kein XML ist"],
  // Processes of this station.
  ["a message of {size} bytes, more than {limit}", "eine Nachricht von {size} Byte, mehr als {limit}"],
  ["message {name}: {reason}", "Nachricht {name}: {reason}"],
  ["unknown message {name}", "unbekannte Nachricht {name}"],
  ["The request is too large for the station.", "Die Anfrage ist zu groß für die Bodenstation."],
  ["an answer that cannot be read ({kind}: {reason})", "eine unlesbare Antwort ({kind}: {reason})"],
  [
    "{process} cannot be started: {reason}; see the log.",
    "{process} kann nicht gestartet werden: {reason}; siehe Protokoll.",
  ],
  ["{process} has ended", "{process} ist beendet"],
  ["{process} has ended (status {status})", "{process} ist beendet (Status {status})"],
  ["{process} has ended ({reason})", "{process} ist beendet ({reason})"],
  ["{process} has run out of memory (limit {limit} GiB)", "{process} hat nicht genug Speicher (Grenze {limit} GiB)"],
  ["{process} has sent {what}", "{process} hat gesendet: {what}"],
  ["{process} has taken longer than {limit} s", "{process} hat länger als {limit} s gebraucht"],
  ["{process} is not running", "{process} läuft nicht"],
  ["{process} is still starting", "{process} startet noch"],
];
