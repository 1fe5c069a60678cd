/** Texts of a page that is opened without the station, or is older than it. */
export const offline = {
  lastState: (time: string) => `No connection to the station. Last state, ${time},`,
  age: (age: string) => `${age} old.`,
  ageUnknown: "age unknown: the clock of this device was set back.",
  noCommands: "Commands are not possible. Use the remote control if needed.",
  otherPage: "The station has another version of this page. Reload before you go on.",
  reload: "Reload",
  notKept: "The last state cannot be kept in this browser: its storage is full or blocked. Free some storage.",
  page: {
    ready: "This page opens without the station, too, and shows the last state.",
    insecure: "This page opens with the station only: the connection is not encrypted.",
    unavailable: "This page opens with the station only: this browser keeps no pages.",
  },
} as const;
