/** German texts of a page that is opened without the station, or is older than it. */
import type { Texts } from "../../texts";

export const offline: Texts["offline"] = {
  lastState: (time) => `Keine Verbindung zur Bodenstation. Letzter Stand, ${time},`,
  age: (age) => `${age} alt.`,
  ageUnknown: "Alter unbekannt: Die Uhr dieses Geräts wurde zurückgestellt.",
  noCommands: "Befehle sind nicht möglich. Bei Bedarf Fernsteuerung benutzen.",
  otherPage: "Die Bodenstation hat eine andere Version dieser Seite. Vor dem Weiterarbeiten neu laden.",
  reload: "Neu laden",
  notKept: "Dieser Browser kann den letzten Stand nicht speichern: Speicher voll oder gesperrt. Speicher freigeben.",
  page: {
    ready: "Diese Seite öffnet sich auch ohne Bodenstation und zeigt den letzten Stand.",
    insecure: "Diese Seite öffnet sich nur mit Bodenstation: Die Verbindung ist nicht verschlüsselt.",
    unavailable: "Diese Seite öffnet sich nur mit Bodenstation: Dieser Browser speichert keine Seiten.",
  },
};
