/** All texts of the page, by namespace; those of larger views have files of their own. A translation has the same shape. */
import type { Action } from "./api/types";
import type { ViewName } from "./shell/route";
import { decide, report } from "./texts/decide";
import { names } from "./texts/names";
import { plan } from "./texts/plan";
import { focus, see } from "./texts/see";
import { understand } from "./texts/understand";
import type { Theme } from "./theme";

const CONSEQUENCE: Readonly<Partial<Record<Action, string>>> = {
  start: "The motors start. Keep people clear of the launch points.",
  join: "The motors start. Keep people clear of the launch points.",
  return: "The vehicles stop searching and fly home to their launch points.",
  land: "The vehicles descend where they are, onto whatever is below them.",
  abort: "The mission ends and cannot be resumed. All vehicles return home.",
  focus:
    "This changes the whole mission from its next step on: the images on all screens and the search for anomalies.",
};

const VIEW: Readonly<Record<ViewName, string>> = {
  plan: "Plan",
  prepare: "Prepare",
  fly: "Fly",
  see: "See",
  understand: "Understand",
  decide: "Decide",
};
const THEME: Readonly<Record<Theme, string>> = { dark: "Dark", light: "Light", contrast: "Sunlight" };

export const texts = {
  title: "aos-gcs",
  waiting: "Waiting for data from the mission …",
  noData: "no data",
  unavailable: "Not available in this phase",
  names,
  requests: {
    notSent: "Not sent: the station cannot be reached. Try again, or use the remote control.",
    unreadableAnswer: "The answer of the station cannot be read. Check the modes of the vehicles.",
  },
  connection: {
    connecting: "Connecting …",
    open: "Connected",
    lost: "Disconnected",
    incompatible: "Reload required",
    silent: "No response",
    lostBanner:
      "No connection to the station: values are out of date. Reconnecting … Use the remote control if needed.",
    incompatibleBanner: "This page and the station have different versions. Reload the page.",
    silentBanner:
      "The mission does not respond: values are out of date, and commands may have no effect. Have the pilots ready.",
    anotherMission: (id: string, formerId: string) => `New mission ${id} (previous: ${formerId})`,
    silentFor: (age: string) => `No response for ${age}.`,
    missed: (count: number) =>
      count === 1
        ? "1 event was missed while this page was disconnected. See the mission record."
        : `${count} events were missed while this page was disconnected. See the mission record.`,
  },
  header: {
    phase: "Phase",
    elapsed: "Elapsed time",
    outcome: "Result",
    step: "Step",
    separation: "Closest distance",
    holdAll: "HOLD ALL",
    holdAllKey: "Key H",
    holdAllHint: "Stop all vehicles where they are. Key H, or Alt+H while typing.",
    observer: "Observer",
    observerHint: "Observers cannot send commands. Sign in with the operator code.",
  },
  signIn: {
    title: "Sign in as operator",
    name: "Name, for the audit log",
    code: "Operator code, printed by the station at its start",
    submit: "Sign in",
    observe: "Continue as observer",
    open: "Sign in",
    signedInAs: (name: string) => `Operator ${name}`,
    signOut: "Sign out",
    expired: "Your sign-in has expired. Sign in again",
  },
  nav: {
    label: "Views",
    view: VIEW,
    key: (key: string) => `Key ${key}`,
    broken: "This view failed. The other views still work, and so does HOLD ALL. Select the view again to retry.",
  },
  dialog: { close: "Close the window" },
  settings: {
    open: "Settings",
    theme: "Theme",
    themes: THEME,
    alerts: "Alert sounds",
    voice: { off: "Off", sound: "Sound", speech: "Sound and speech" },
    close: "Close",
  },
  scope: {
    label: "Send to",
    selection: "Selection",
    clear: "Clear selection",
    mission: "the mission",
    waiting: "all waiting on the ground",
    all: (count: number) => `all ${count}`,
    some: (ids: readonly number[], count: number) => `${ids.length} of ${count}: ${ids.join(", ")}`,
  },
  actions: {
    panel: "Commands",
    consequence: CONSEQUENCE,
    cancel: "Cancel",
    holdTo: (action: Action) => `Hold to ${names.action[action].toLowerCase()}`,
    results: "Recent commands",
    noResults: "No command has been sent from this page yet.",
    pending: "Sending …",
    accepted: "Accepted",
    refused: "refused",
    summary: (accepted: number, refused: number) =>
      refused === 0 ? `${accepted} accepted` : `${accepted} accepted, ${refused} refused`,
    dismiss: "Dismiss",
  },
  alerts: {
    panel: "Alerts",
    times: (count: number) => `${count}×`,
    vehicle: (id: number, text: string) => `Vehicle ${id}: ${text}`,
    acknowledge: "Acknowledge",
    acknowledgeAll: (count: number) => `Acknowledge all ${count}`,
    more: (count: number) => `${count} more`,
    connectionLost: "Connection to the station lost",
    missionSilent: "The mission does not respond",
    acknowledged: (operator: string, time: string) => `acknowledged by ${operator || "an operator"}, ${time}`,
  },
  keys: {
    title: "Keyboard shortcuts",
    list: [
      ["H", "Hold all vehicles; Alt+H while typing"],
      ["P R F S U D", "Plan, Prepare, Fly, See, Understand, Decide"],
      ["1 … 9", "Select a vehicle by number; type 1 2 for vehicle 12"],
      ["Shift + number", "Add a vehicle to the selection"],
      ["A", "Select all vehicles"],
      ["Escape", "Clear the selection; close a window"],
      ["Ctrl+Z", "Plan: undo; with Shift: redo"],
      ["?", "Settings and keyboard shortcuts"],
      ["Space", "Replay: play, pause"],
      ["← →", "Replay: 10 s back, forward"],
      [", .", "Replay: previous, next step"],
      ["[ ]", "Replay: previous, next event"],
      ["+ −", "Replay: faster, slower"],
    ],
  },
  map: {
    panel: "Map",
    fit: "Fit to fleet",
    layers: "Layers",
    picture: "Image",
    noPicture: "None",
    opacity: "Opacity",
    noWebGl: "The map needs WebGL, which this browser does not provide. Everything else on this page works.",
    noOrigin: "The map appears when the first vehicle has reported its position.",
    cursor: "Cursor position",
    layer: {
      basemap: "Base map",
      grid: "Metric grid",
      area: "Search area, geofence, no-go zones",
      legs: "Scan legs",
      homes: "Launch points",
      footprints: "Camera footprints",
      trails: "Trails",
      waypoints: "Waypoints",
      targets: "Targets",
      heights: "Heights of all vehicles",
      vehicles: "Vehicles",
    },
    target: (trackId: number) => (trackId === 0 ? "Target" : `Target ${trackId}`),
  },
  fleet: {
    panel: "Fleet",
    none: "No vehicle connected yet.",
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
      message: "Message",
    },
    armed: "armed",
    disarmed: "disarmed",
    neverHeard: "no contact",
    linkHint: "Age of the last message, packet loss, round-trip time",
    selectRow: (id: number) => `Select vehicle ${id}`,
  },
  target: {
    panel: "Targets",
    none: "No targets yet.",
    sightings: (count: number) => (count === 1 ? "1 sighting" : `${count} sightings`),
    error: (sigma: string) => `± ${sigma} (1 σ)`,
    person: (probability: string) => `Possible person (${probability})`,
  },
  see,
  focus,
  understand,
  replay: {
    bar: "Replay",
    mark: "REPLAY",
    time: "Time in the recording",
    play: "Play",
    stop: "Pause",
    stepBefore: "‹ Step",
    stepAfter: "Step ›",
    eventBefore: "‹ Event",
    eventAfter: "Event ›",
    events: "Events and findings",
    finding: (findingId: number, status: string) => `Finding ${findingId} (${status})`,
    more: (count: number) => `and ${count} more`,
    speed: "Speed",
    times: (speed: number) => `${speed}×`,
    phaseAt: (phase: string, time: string) => `${phase}, from ${time}`,
  },
  events: {
    panel: "Events",
    none: "No events yet.",
    all: "All",
    missing: (count: number) => `${count} events not shown. See the mission record.`,
  },
  prepare: {
    panel: "Preflight checks",
    none: "The checks start when vehicles are connected.",
    vehicle: "Vehicle",
    vehicles: "Vehicles",
    mission: "Mission",
    status: { pass: "passed", warn: "warning", fail: "failed" },
    overridden: "overridden",
    cell: (check: string, subject: string, status: string) => `${check}, ${subject}: ${status}`,
    detail: "Check",
    choose: "Select a check to see its result and what to do.",
    found: "Result",
    remedy: "What to do",
    overriddenBy: (name: string) => (name === "" ? "Overridden" : `Overridden by ${name}`),
    takeBack: "Remove override",
    override: "Override",
    reason: "Reason, for the audit log",
    notOverridable: "This check cannot be overridden.",
    launch: "Launch",
    blockers: "Blocking issues",
    noBlockers: (warnings: number) => {
      if (warnings === 0) return "Ready to launch";
      return warnings === 1 ? "Ready to launch, 1 warning" : `Ready to launch, ${warnings} warnings`;
    },
    inFlight: "The mission has started. The checks show the state at its start.",
  },
  fields: {
    notNumber: "Enter a number",
    range: (min: number, max: number) => {
      if (max === Infinity) return `Enter ${min} or more`;
      return min === -Infinity ? `Enter ${max} or less` : `Enter a number from ${min} to ${max}`;
    },
  },
  plan,
  decide,
  report,
} as const;
