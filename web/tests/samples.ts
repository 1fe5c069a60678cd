/** Small valid messages for the tests. */
import type { Finding, Mission, Notice, Position, Step, StepFigures, Target, Vehicle } from "../src/api/types";

export function position(east_m: number, north_m: number, up_m = 30): Position {
  return { east_m, north_m, up_m, latitude_deg: null, longitude_deg: null };
}

export function vehicle(id: number, changes: Partial<Vehicle> = {}): Vehicle {
  return {
    vehicle_id: id,
    autopilot: "px4",
    mode: "guided",
    mode_name: "",
    task: "swarm",
    takes_part: true,
    landed: "in_air",
    armed: true,
    ready_to_arm: true,
    position: position(10 * id, 0),
    position_age_s: 0.1,
    altitude_amsl_m: 300,
    height_above_home_m: 30,
    height_above_ground_m: null,
    ground_speed_mps: 4,
    climb_rate_mps: 0,
    heading_deg: 90,
    home: position(0, 0, 0),
    battery_percent: 80,
    battery_voltage_v: 15,
    gps_fix: 3,
    satellites: 12,
    link_age_s: 0.2,
    components: [],
    link: null,
    camera: null,
    leaves_in_s: null,
    relay_ready: null,
    packet_loss_percent: 0,
    layer_height_m: 30,
    waypoint: null,
    refusal: null,
    text: "",
    ...changes,
  };
}

export function mission(changes: Partial<Mission> = {}): Mission {
  return {
    mission_id: "m1",
    strategy: "aos-apso",
    phase: "scan",
    suspension: "none",
    outcome: "open",
    message: "",
    elapsed_s: 10,
    started_utc_s: null,
    step: 1,
    origin: { latitude_deg: 48, longitude_deg: 14, altitude_amsl_m: 250 },
    area: [],
    fence: [],
    no_go: [],
    legs: [],
    leg: 0,
    covered_percent: null,
    ground: null,
    scan_left_s: null,
    vehicles: [vehicle(1), vehicle(2)],
    planned_vehicles: 2,
    preflight: [],
    target: null,
    targets: [],
    left_for_later: [],
    findings: [],
    acknowledgements: [],
    sharing: [],
    proposals: [],
    command_count: 0,
    min_separation_m: null,
    focus: { height_m: 0, source: "configured", sigma_m: null },
    control: null,
    replay: null,
    allowed_actions: ["pause", "hold", "return", "land", "abort"],
    ...changes,
  };
}

export function notice(notice_id: number, text: string, changes: Partial<Notice> = {}): Notice {
  return { severity: "warning", notice_id, text, vehicle_id: null, track_id: null, elapsed_s: 0, utc_s: 0, ...changes };
}

export const CAPABILITIES = {
  planning: true,
  viewer: true,
  findings: true,
  operation: true,
  survey: false,
  handover: true,
  wall: true,
  video: true,
} as const;

export function target(changes: Partial<Target> = {}): Target {
  return {
    track_id: 1,
    confirmed: true,
    position: position(0, 0, 0),
    sigma_m: 2,
    ellipse: null,
    speed_mps: null,
    sightings: 3,
    person_confidence: null,
    kind: "undecided",
    reasons: [],
    seen_at_s: null,
    ...changes,
  };
}

export function finding(id: number, changes: Partial<Finding> = {}): Finding {
  return {
    finding_id: id,
    status: "new",
    position: position(10 * id, 5, 0),
    dms: null,
    utm: null,
    mgrs: null,
    sigma_m: 1,
    ellipse: null,
    sightings: 4,
    person_confidence: 0.7,
    kind: "person",
    reasons: [],
    significance: null,
    track_id: id,
    found_at_s: 20,
    seen_at_s: 30,
    step: 3,
    comment: "",
    assignee: "",
    operator: "",
    merged_into: null,
    found_in: "",
    ...changes,
  };
}

export function step(number: number, changes: Partial<Step> = {}): Step {
  return { ...figures(number), target: null, fitness: [], missing: [], waypoints: [], ...changes };
}

export function figures(number: number, changes: Partial<StepFigures> = {}): StepFigures {
  return {
    step: number,
    elapsed_s: 2 * number,
    phase: "scan",
    visibility_m2: 0.1 * number,
    threshold_m2: 0.3,
    branch: "line",
    evolutionary_factor: null,
    evolutionary_state: null,
    c_s_m: null,
    c_c_m: null,
    leader_id: null,
    imaging_ms: 1,
    work_ms: 1,
    loop_lag_p99_ms: 1,
    ...changes,
  };
}
