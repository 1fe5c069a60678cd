/** Texts of the view Fly. */

export const heights = {
  agl: "AGL",
  home: "home",
  aboveGround: "above ground",
  aboveHome: "above home",
  aboveSea: "above sea level",
} as const;

export const fleet = {
  panel: "Fleet",
  none: "No vehicle connected yet.",
  nonePass: "No vehicle passes this filter.",
  filter: "Show",
  filters: { all: "All", attention: "Attention", airborne: "Airborne", battery: "Low battery" },
  view: "View",
  viewTitle: "View of the fleet on this screen",
  layout: "Layout",
  layouts: { tiles: "Tiles", table: "Table" },
  order: "Order",
  orders: { worst: "Worst first", number: "By number" },
  columnsTitle: "Columns of the table",
  select: "Select",
  id: "ID",
  columns: {
    mode: "Mode",
    task: "Task",
    armed: "Armed",
    battery: "Battery",
    gps: "GPS",
    link: "Link",
    height: "Height",
    message: "Message",
  },
  armed: "armed",
  disarmed: "disarmed",
  neverHeard: "no contact",
  linkHint: "Age of the last message, packet loss, round-trip time",
  selectRow: (id: number) => `Select vehicle ${id}`,
} as const;

export const attention = {
  neverHeard: "no contact yet",
  silent: (age: string) => `no contact ${age}`,
  fix: (fix: string) => `GPS: ${fix}`,
  battery: (percent: string) => `battery ${percent}`,
  loss: (percent: string) => `loss ${percent}`,
  camera: (reason: string) => `no image: ${reason}`,
} as const;

export const vehicle = {
  panel: (id: number) => `Vehicle ${id}`,
  close: "Close",
  toFrames: "Frames of all vehicles",
  frame: (kind: string, id: number, step: number) => `${kind} frame of vehicle ${id}, step ${step}`,
  caption: (kind: string, step: number) => `${kind}, step ${step}`,
  roundTrip: "Round-trip time",
  speed: "Ground speed",
  away: "From its launch point",
  frames: "Frames",
  framesOf: (frames: number, missing: number) => `${frames}, ${missing} missing`,
  heading: "Heading",
} as const;

export const relay = {
  panel: "Battery relay",
  next: (id: number) => `Leaves next: vehicle ${id}`,
  leavesIn: (time: string) => `in ${time}`,
  due: "now",
  ready: "ready to take off",
  unconfirmed: "on the ground: not confirmed as ready",
} as const;

export const target = {
  panel: "Targets",
  none: "No targets yet.",
  sightings: (count: number) => (count === 1 ? "1 sighting" : `${count} sightings`),
  error: (sigma: string) => `± ${sigma} (1 σ)`,
  taken: (kind: string, probability: string) => `${kind} (person: ${probability})`,
  later: "Left for a later look",
  person: (probability: string) => `person: ${probability}`,
} as const;
