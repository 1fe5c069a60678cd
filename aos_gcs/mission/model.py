"""The mission as others see it: phases, snapshots, step records, operator's actions and events.

All of it is frozen data; the API, the store and the tests read it, only the coordinator makes it. Positions are ENU
metres about the mission's origin; ``origin`` in the snapshot places them on the globe.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.ports import Severity, VehicleState


class Phase(StrEnum):
    """Where a mission is. ARCHITECTURE.md draws the transitions."""

    CONNECT = "connect"
    PREFLIGHT = "preflight"
    READY = "ready"
    """Preflight has passed; waits for the operator's start."""
    ARM = "arm"
    TAKEOFF = "takeoff"
    LINE = "line"
    SCAN = "scan"
    CONVERGE = "converge"
    FOUND = "found"
    RETURN = "return"
    LAND = "land"
    DONE = "done"


class Suspension(StrEnum):
    """Why a flying mission makes no steps at present."""

    NONE = "none"
    PAUSED = "paused"
    """The step in hand was finished; the vehicles hover at their waypoints."""
    HELD = "held"
    """All vehicles were stopped where they were."""


class Outcome(StrEnum):
    """How a mission has ended, or that it has not."""

    OPEN = "open"
    FOUND = "found"
    NOT_FOUND = "not_found"
    ABORTED = "aborted"
    FAILED = "failed"


class Task(StrEnum):
    """What the coordinator has a vehicle do."""

    IDLE = "idle"
    JOINING = "joining"
    """Climbs in mid-mission and flies to the swarm."""
    SWARM = "swarm"
    HELD = "held"
    RETURNING = "returning"
    LANDING = "landing"
    LANDED = "landed"
    LOST = "lost"
    """Silent for longer than the link-loss limit; its own failsafe flies it."""


class Action(StrEnum):
    """What an operator can ask for."""

    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    HOLD = "hold"
    RETURN = "return"
    LAND = "land"
    ABORT = "abort"
    FOCUS = "focus"
    """Focus on a height that the operator gives, or leave it to autofocus again."""
    JOIN = "join"
    """Have vehicles on the ground take off and join the swarm in mid-mission."""
    OVERRIDE = "override"
    """Launch in spite of a failed check of preflight, or take that back; see ``MissionControl.override_check``."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """Reason why something that was asked of a vehicle is not done."""

    text: str


@dataclass(frozen=True, slots=True)
class ActionResult:
    """What became of an action for one vehicle."""

    vehicle_id: int
    accepted: bool
    text: str
    """In words: what the vehicle does now, or why it does not."""


@dataclass(frozen=True, slots=True)
class ActionRecord:
    """An operator's action: one entry of the audit log."""

    utc_s: float
    action: Action
    vehicle_ids: tuple[int, ...] | None
    """None for the whole mission."""
    results: tuple[ActionResult, ...]
    refusal: str | None = None
    """Why the mission did not take the action; None if it did."""
    focal_height_m: float | None = None
    """What an action of focusing asked for; None leaves the height to autofocus."""
    operator: str = ""
    """Who has asked for it, as given at sign-in; empty when it came from no person."""
    check: str | None = None
    """The check that an override concerns."""
    reason: str | None = None
    """Why a check was overridden; None where an override was taken back."""


@dataclass(frozen=True, slots=True)
class SettingsRecord:
    """Settings of a vehicle that the mission changes for its time."""

    utc_s: float
    vehicle_id: int
    purpose: str
    former: Mapping[str, float]
    """Values before the mission, by the autopilot's own names."""
    is_restored: bool = False
    """False: the mission is about to write others; True: the vehicle has these again."""


@dataclass(frozen=True, slots=True)
class OutcomeRecord:
    """How the mission has ended."""

    utc_s: float
    outcome: Outcome
    summary: Mapping[str, object]
    """The figures of the whole mission, such as the number of steps."""


class CheckStatus(StrEnum):
    """What a check of preflight has found."""

    PASS = "pass"  # noqa: S105 - no password
    WARN = "warn"
    """Worth knowing; does not stand against the launch."""
    FAIL = "fail"
    """Stands against the launch, unless it is overridden."""


@dataclass(frozen=True, slots=True)
class CheckOverride:
    """The decision to launch in spite of a failed check."""

    reason: str
    by: str
    """The operator's name as given at sign-in, or ``configuration``; empty when no name was given."""
    utc_s: float


@dataclass(frozen=True, slots=True)
class PreflightCheck:
    """One cell of the matrix vehicle x check."""

    vehicle_id: int
    """0: the mission as a whole."""
    name: str
    status: CheckStatus
    text: str
    """What was found."""
    remedy: str = ""
    """What to do about it; empty where the check passes."""
    overridable: bool = False
    """Whether the operator may launch in spite of a failure."""
    overridden: CheckOverride | None = None
    """Cleared as soon as something else is found."""

    @property
    def blocks(self) -> bool:
        """Whether it stands against the launch."""
        return self.status is CheckStatus.FAIL and self.overridden is None

    def describe(self) -> str:
        """Return finding and remedy in one sentence without an end: ``vehicle 3, battery: 40 %; change it``."""
        subject = f"vehicle {self.vehicle_id}, {self.name}" if self.vehicle_id else self.name
        return f"{subject}: {self.text}; {self.remedy}" if self.remedy else f"{subject}: {self.text}"


@dataclass(frozen=True, slots=True)
class CameraSnapshot:
    """What a vehicle's camera has delivered in this mission."""

    frames: int = 0
    """That could be used."""
    failures: int = 0
    """Steps that went on without its frame."""
    last_step: int | None = None
    """Of its latest frame."""
    footprint_enu_m: tuple[tuple[float, float], ...] = ()
    """What that frame shows of the focal plane; empty before the first one, and where it sees the horizon."""
    failure: str | None = None
    """Why its frame is missing in the latest step; None if it is not."""


@dataclass(frozen=True, slots=True)
class VehicleSnapshot:
    """One vehicle in the mission."""

    telemetry: VehicleState
    task: Task
    layer_height_m: float | None
    """The altitude layer it flies in, metres above the origin."""
    position_enu_m: EnuPoint | None
    link_age_s: float | None
    """Seconds since its last message; None if never heard."""
    waypoint_enu_m: EnuPoint | None
    """Where it was last sent."""
    refusal: str | None
    """Why its last planned waypoint was shortened or held; None if it was sent as planned."""
    camera: CameraSnapshot | None = None
    """None in older records."""


@dataclass(frozen=True, slots=True)
class ErrorEllipse:
    """One standard deviation of a horizontal position; holds the truth with a probability of 39 %."""

    semi_major_m: float
    semi_minor_m: float
    heading_rad: float
    """Of the major axis, clockwise from north, [0, pi]."""


@dataclass(frozen=True, slots=True)
class TargetEstimate:
    """Where a target is believed to be. Records of older missions lack what has a default."""

    position_enu_m: EnuPoint
    """Of the ground below it, at the latest step."""
    sigma_m: float | None
    """Standard deviation along a horizontal axis, the mean over all directions; None when it is not known."""
    sightings: int
    track_id: int = 0
    """Counts from 1 in a mission; 0: not known."""
    confirmed: bool = True
    """Seen often enough to be no false alarm."""
    ellipse: ErrorEllipse | None = None
    velocity_enu_mps: tuple[float, float] | None = None
    """Horizontal."""
    seen_at_s: float | None = None
    """Mission time of the latest sighting."""
    person_confidence: float | None = None
    """Probability that it is a person rather than another warm body; None when no temperatures tell."""


class FindingStatus(StrEnum):
    """What the operators think of a finding."""

    NEW = "new"
    CONFIRMED = "confirmed"
    REJECTED = "rejected"


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that searchers should know of: a confirmed target, or what an operator has marked."""

    finding_id: int
    """Counts from 1."""
    status: FindingStatus
    position_enu_m: EnuPoint
    """Of the ground below it."""
    found_at_s: float
    """Mission time at which it was first known."""
    seen_at_s: float
    """Mission time of the latest sighting; of one marked by hand, when it was marked."""
    step: int
    """At which it was seen last, whose frames show it."""
    track_id: int | None = None
    """The target that it follows; None for one marked by hand."""
    sigma_m: float | None = None
    ellipse: ErrorEllipse | None = None
    sightings: int = 0
    person_confidence: float | None = None
    comment: str = ""
    assignee: str = ""
    """Who is to look after it."""
    operator: str = ""
    """Who has judged it last, or marked it."""


@dataclass(frozen=True, slots=True)
class FindingChange:
    """What an operator changes of a finding; None leaves a thing as it is."""

    status: FindingStatus | None = None
    comment: str | None = None
    assignee: str | None = None


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """An operator has taken note of a notice, and of all before it that say the same of the same vehicle."""

    notice_id: int
    operator: str
    """The name as given at sign-in; empty when no name was given."""
    utc_s: float


class FocusSource(StrEnum):
    """Who has chosen the focal height."""

    CONFIGURED = "configured"
    AUTOFOCUS = "autofocus"
    OPERATOR = "operator"


@dataclass(frozen=True, slots=True)
class FocusSnapshot:
    """The focal plane in use."""

    height_m: float
    """Above the origin."""
    source: FocusSource
    sigma_m: float | None
    """Standard deviation of what autofocus has found; None for other sources."""


@dataclass(frozen=True, slots=True)
class MissionSnapshot:
    """The whole mission at one moment."""

    mission_id: str
    strategy: str
    phase: Phase
    suspension: Suspension
    outcome: Outcome
    message: str
    """What the mission is waiting for or doing, in one sentence."""
    elapsed_s: float
    """Clock seconds since the start action; 0 before."""
    step: int
    origin: GeodeticPosition | None
    """Of the ENU frame; None until it is known."""
    area_enu_m: tuple[tuple[float, float], ...]
    """Search area, a polygon."""
    fence_enu_m: tuple[tuple[float, float], ...]
    """Geofence, a polygon around the search area and the launch site."""
    vehicles: tuple[VehicleSnapshot, ...]
    preflight: tuple[PreflightCheck, ...]
    target: TargetEstimate | None
    """The target in view, or else the one that was seen last."""
    min_separation_m: float | None
    """The smallest 3-D distance measured between two vehicles so far."""
    targets: tuple[TargetEstimate, ...] = ()
    """All that are confirmed, and ``target``."""
    focus: FocusSnapshot | None = None
    """None in records of missions before there was autofocus."""
    no_go_enu_m: tuple[tuple[tuple[float, float], ...], ...] = ()
    """Polygons that no vehicle enters."""
    legs_enu_m: tuple[tuple[tuple[float, float], tuple[float, float]], ...] = ()
    """Start and end of each leg of the scan, by the middle of the swarm's line; empty before they are planned."""
    leg: int = 0
    """Index of the leg being flown."""
    covered_fraction: float | None = None
    """Share of the search area that was in a frame; None before the first step."""
    findings: tuple[Finding, ...] = ()
    """Oldest first."""
    acknowledgements: tuple[Acknowledgement, ...] = ()
    """The latest ones, by the number of their notice."""


@dataclass(frozen=True, slots=True)
class StepRecord:
    """One step: what was seen, what was decided."""

    step: int
    elapsed_s: float
    phase: Phase
    visibility_m2: float
    threshold_m2: float
    branch: str
    evolutionary_factor: float | None
    evolutionary_state: str | None
    c_s_m: float | None
    c_c_m: float | None
    leader_id: int | None
    target_enu_m: EnuPoint | None
    """This step's own measurement, when the target is in view."""
    fitness: dict[int, float]
    """f per vehicle that delivered a frame."""
    missing: dict[int, str]
    """Vehicles that the step went on without, with the reason."""
    waypoints: tuple[WaypointRecord, ...]
    imaging_ms: float
    work_ms: float
    """From the last frame received to the last goto handed to the link, real milliseconds."""
    loop_lag_p99_ms: float
    """99th percentile of the event loop's lag since the previous step, real milliseconds."""
    visibility_present_m2: float | None = None
    """The part of ``visibility_m2`` that this step's own frames show; None in older records."""
    focal_height_m: float | None = None
    """Of the plane that this step's frames were integrated on."""


class PictureKind(StrEnum):
    """The rasters that are shown live."""

    INTEGRAL = "integral"
    """Colour (or grey) integral."""
    THERMAL = "thermal"
    ANOMALY = "anomaly"
    """Number of frames that mark each cell."""
    COVERAGE = "coverage"
    """How many frames of the whole mission show each place of the search area."""
    VISIBILITY = "visibility"
    """What share of the ground these have seen at most, through a canopy of the configured density."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A north-up raster on the focal plane, ready to show."""

    kind: PictureKind
    step: int
    png: bytes = field(repr=False)
    """RGBA; transparent where nothing covers."""
    west_m: float
    south_m: float
    east_m: float
    north_m: float


@dataclass(frozen=True, slots=True)
class PlanRecord:
    """A plan that the mission flies from now on."""

    plan: MissionPlan
    operator: str
    """Who has applied it."""


@dataclass(frozen=True, slots=True)
class JumpRecord:
    """A replay has gone to another time, and what was told before is no longer so."""

    notices: tuple[NoticeRecord, ...]
    """Of the mission up to that time."""


class EventKind(StrEnum):
    """What an event carries in ``data``."""

    SNAPSHOT = "snapshot"
    """MissionSnapshot, a few times per second."""
    STEP = "step"
    """StepRecord."""
    NOTICE = "notice"
    """NoticeRecord."""
    PICTURES = "pictures"
    """PicturesRecord: new rasters can be fetched."""
    PLAN = "plan"
    """PlanRecord."""
    JUMP = "jump"
    """JumpRecord; in replays alone."""


@dataclass(frozen=True, slots=True)
class NoticeRecord:
    """Something that happened, for the operator and the log. Older records have neither number (from 1) nor time."""

    severity: Severity
    text: str
    vehicle_id: int | None
    elapsed_s: float
    notice_id: int = 0
    utc_s: float = 0.0


@dataclass(frozen=True, slots=True)
class PicturesRecord:
    """Rasters of a step are ready."""

    step: int
    kinds: tuple[PictureKind, ...]
    west_m: float
    south_m: float
    east_m: float
    north_m: float


EventData = MissionSnapshot | StepRecord | NoticeRecord | PicturesRecord | PlanRecord | JumpRecord


@dataclass(frozen=True, slots=True)
class Event:
    """One entry of the mission's only event stream."""

    seq: int
    """Counts from 1 without gaps; a subscriber that sees a gap has lost events to its own slowness."""
    utc_s: float
    kind: EventKind
    data: EventData
