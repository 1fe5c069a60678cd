/** Every word on the page, in one place. */
import type { Action, PictureKind, Severity } from "./api/types";

const GPS_FIX: Readonly<Record<number, string>> = {
  0: "no GPS",
  1: "no fix",
  2: "2D",
  3: "3D",
  4: "DGPS",
  5: "RTK float",
  6: "RTK",
  7: "static",
  8: "PPP",
};

const VERB: Readonly<Record<Action, string>> = {
  start: "Start",
  pause: "Pause",
  resume: "Resume",
  hold: "Hold",
  return: "Return",
  land: "Land",
  abort: "Abort",
  focus: "Focus",
};

const QUESTION: Readonly<Partial<Record<Action, string>>> = {
  return: "Every one of them stops searching and flies home to its launch point.",
  land: "They descend where they are now, onto whatever is below them.",
  abort: "The mission ends and cannot be resumed; all vehicles come home.",
};

const PICTURE: Readonly<Record<PictureKind, string>> = {
  integral: "Integral",
  thermal: "Thermal",
  anomaly: "Anomaly",
};

const SEVERITY: Readonly<Record<Severity, string>> = { info: "Info", warning: "Warning", critical: "Critical" };

export const texts = {
  title: "aos-gcs",
  connection: {
    connecting: "Connecting …",
    open: "Connected",
    lost: "Disconnected",
    incompatible: "Reload needed",
    lostBanner: "No connection to the service. Values below are old; trying to connect again …",
    incompatibleBanner: "The service and this page do not understand each other. Reload the page.",
  },
  header: {
    phase: "Phase",
    elapsed: "Elapsed",
    step: "Step",
    strategy: "Strategy",
    outcome: "Outcome",
    separation: "Closest pair",
    focus: "Focal plane",
    theme: { dark: "Light theme", light: "Dark theme" },
  },
  waiting: "Waiting for the first data of the mission …",
  scope: {
    all: "all vehicles",
    one: (id: number) => `vehicle ${id}`,
    many: (count: number) => `${count} selected vehicles`,
    several: (ids: string) => `vehicles ${ids}`,
    label: "To",
    clear: "All",
    mission: "the mission",
  },
  actions: {
    panel: "Mission control",
    verb: VERB,
    label: (action: Action, scope: string) => `${VERB[action]} ${scope}`,
    question: QUESTION,
    cancel: "Cancel",
    results: "Last command",
    pending: "Sending …",
    holdKey: "Key H",
    done: "done",
    refused: "refused",
    notSent: "Not sent: the service cannot be reached. Try again, or use the remote control.",
    unreadableAnswer: "The service's answer cannot be read; look at the vehicles' modes.",
    unavailable: "Not possible in this phase",
  },
  target: {
    panel: "Target estimate",
    none: "None yet",
    sightings: (count: number) => (count === 1 ? "1 sighting" : `${count} sightings`),
    sigma: "1 σ",
  },
  vehicles: {
    panel: "Vehicles",
    none: "No vehicle has been heard yet.",
    columns: {
      select: "Select",
      id: "ID",
      mode: "Mode",
      task: "Task",
      armed: "Armed",
      battery: "Battery",
      gps: "GPS",
      link: "Link",
      height: "Height",
      speed: "Speed",
      message: "Message",
    },
    armed: "armed",
    disarmed: "safe",
    neverHeard: "never heard",
    selectRow: (id: number) => `Select vehicle ${id}`,
  },
  map: {
    panel: "Map",
    fit: "Fit to fleet",
    layer: "Overlay",
    noLayer: "None",
    opacity: "Opacity",
    noWebGl: "The map needs WebGL, which this browser does not offer. Everything else on this page works.",
    noOrigin: "The map appears when the first vehicle has reported its position.",
    cursor: "Cursor",
    target: "Estimated target",
    vehicle: (id: number) => `Vehicle ${id}`,
    legend: { area: "Search area", fence: "Fence", waypoint: "Waypoint", refused: "Refused", home: "Launch point" },
  },
  pictures: {
    panel: "View through the canopy",
    kind: PICTURE,
    none: "The first picture comes with the first step of the scan.",
    alt: (kind: PictureKind, step: number) => `${PICTURE[kind]} image of step ${step}, north up`,
    enlarge: "Enlarge",
    close: "Close",
    step: (step: number) => `step ${step}`,
  },
  chart: {
    panel: "Visibility",
    threshold: "threshold",
    factor: "e_f",
    none: "The curve begins with the first step.",
    state: "state",
    branch: "branch",
    aria: (value: string, threshold: string) => `Visibility ${value}, threshold ${threshold}`,
  },
  events: { panel: "Events", none: "Nothing has happened yet.", severity: SEVERITY, all: "All", vehicle: "vehicle" },
  preflight: {
    panel: "Preflight",
    none: "The checks begin when the vehicles are heard.",
    passed: "passed",
    failed: "failed",
    problems: "To be mended",
    allPassed: "All checks have passed.",
  },
  gpsFix: GPS_FIX,
} as const;
