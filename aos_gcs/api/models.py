"""Wire models of the API: what a client sees.

Angles are degrees, lengths metres, times seconds; positions carry ENU metres about the mission's origin and, when that
origin is known, WGS84 degrees beside them. ``null`` always means *not known*, never zero.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.api.access import Role
from aos_gcs.mission.model import (
    Action,
    CheckStatus,
    FindingStatus,
    FocusSource,
    Outcome,
    Phase,
    PictureKind,
    Suspension,
    Task,
)
from aos_gcs.ports import FlightMode, LandedState, Severity

SCHEMA_VERSION = 3
"""Raised when a client written for the earlier number would misread a message."""


class WireModel(BaseModel):
    """Base of all wire models: unknown fields are refused, instances are not changed after they are made."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class GeodeticModel(WireModel):
    """A WGS84 position with its altitude above mean sea level."""

    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: float


class PositionModel(WireModel):
    """A point in the mission's ENU frame, with its place on the globe when the origin is known."""

    east_m: float
    north_m: float
    up_m: float
    latitude_deg: float | None
    longitude_deg: float | None


class VertexModel(WireModel):
    """A corner of a polygon or a picture on the ground plane."""

    east_m: float
    north_m: float
    latitude_deg: float | None
    longitude_deg: float | None


class LinkModel(WireModel):
    """How well a vehicle is reached; its packet loss and age stand in VehicleModel."""

    address: str = Field(description="Where it is spoken to now.")
    living_addresses: int = Field(description="At how many addresses, on all links together, it is being heard.")
    round_trip_ms: float | None
    clock_offset_ms: float | None = Field(description="The vehicle's clock minus ours.")
    clock_drift_ppm: float | None = Field(description="What the vehicle's clock gains on ours.")


class CameraModel(WireModel):
    """What a vehicle's camera has delivered in this mission."""

    frames: int = Field(description="That could be used.")
    failures: int = Field(description="Steps that went on without its frame.")
    last_step: int | None
    footprint: list[VertexModel] = Field(
        description="What its latest frame shows of the focal plane; empty before the first one."
    )
    failure: str | None = Field(description="Why its frame is missing in the latest step.")
    source: str = Field(description="How frames come, in the driver's own word; empty if not known.")
    refused: int = Field(description="That came with a pose or a time that cannot be trusted.")
    late: int = Field(description="That were not there by the deadline.")
    torn: int = Field(description="That were not whole by the deadline.")


class ScanLegModel(WireModel):
    """One sweep of the swarm's line, by the way of its middle."""

    start: VertexModel
    end: VertexModel


class VehicleModel(WireModel):
    """One vehicle in the mission. Everything but its id is ``null`` until the vehicle has reported it."""

    vehicle_id: int
    autopilot: str
    mode: FlightMode
    mode_name: str = Field(description="The autopilot's own word for its mode.")
    task: Task
    landed: LandedState
    armed: bool | None
    ready_to_arm: bool | None
    position: PositionModel | None
    position_age_s: float | None
    altitude_amsl_m: float | None
    height_above_home_m: float | None
    ground_speed_mps: float | None
    climb_rate_mps: float | None
    heading_deg: float | None = Field(description="Clockwise from true north, [0, 360).")
    home: PositionModel | None
    battery_percent: float | None
    battery_voltage_v: float | None
    gps_fix: int | None = Field(description="MAVLink's GPS_FIX_TYPE; 3 and above is a 3D fix.")
    satellites: int | None
    link_age_s: float | None = Field(description="Seconds since its last message; null if never heard.")
    packet_loss_percent: float | None
    layer_height_m: float | None
    waypoint: PositionModel | None = Field(description="Where it was last sent.")
    refusal: str | None = Field(description="Why its last planned waypoint was shortened or held.")
    text: str = Field(description="Its latest status text of severity warning or worse.")
    link: LinkModel | None
    camera: CameraModel | None


class OverrideModel(WireModel):
    """The decision to launch in spite of a failed check."""

    reason: str
    by: str = Field(description="The operator's name, or 'configuration'; empty when no name was given.")
    utc_s: float


class PreflightCheckModel(WireModel):
    """One cell of the matrix vehicle x check."""

    vehicle_id: int = Field(description="0: the mission as a whole.")
    name: str
    status: CheckStatus
    text: str = Field(description="What was found.")
    remedy: str = Field(description="What to do about it; empty where the check passes.")
    overridable: bool = Field(description="Whether an operator may launch in spite of it.")
    overridden: OverrideModel | None
    blocks: bool = Field(description="Whether it stands against the launch: failed, and not overridden.")


class OverrideRequest(WireModel):
    """The wish to launch in spite of a failed check, or to take that back."""

    vehicle_id: Annotated[int, Field(ge=0, le=255)]
    check: Annotated[str, Field(min_length=1, max_length=40)] = Field(description="The check's name.")
    reason: Annotated[str, Field(min_length=1, max_length=500)] | None = Field(
        description="For the record; null takes an override back."
    )


class EllipseModel(WireModel):
    """One standard deviation of a horizontal position; holds the truth with a probability of 39 %."""

    semi_major_m: float
    semi_minor_m: float
    heading_deg: float = Field(description="Of the major axis, clockwise from true north, [0, 180].")


class TargetModel(WireModel):
    """Where a target is believed to be."""

    track_id: int = Field(description="Counts from 1 in a mission; 0 if not known.")
    confirmed: bool = Field(description="Seen often enough to be no false alarm.")
    position: PositionModel
    sigma_m: float | None
    ellipse: EllipseModel | None
    speed_mps: float | None
    sightings: int
    seen_at_s: float | None = Field(description="Mission time of the latest sighting.")
    person_confidence: float | None = Field(
        description="Probability, 0 to 1, that it is a person rather than another warm body; null if nothing tells."
    )


class FindingModel(WireModel):
    """Something that searchers should know of."""

    finding_id: int
    status: FindingStatus
    position: PositionModel
    dms: str | None = Field(description="Degrees, minutes and seconds; null while the origin is unknown.")
    utm: str | None
    mgrs: str | None
    sigma_m: float | None
    ellipse: EllipseModel | None
    sightings: int
    person_confidence: float | None = Field(description="Probability, 0 to 1; null if nothing tells.")
    track_id: int | None = Field(description="Of the target; null if an operator has marked it.")
    found_at_s: float = Field(description="Mission time at which it was first known.")
    seen_at_s: float
    step: int = Field(description="Whose frames show it.")
    comment: str
    assignee: str
    operator: str = Field(description="Who has judged it last, or marked it.")


class AcknowledgementModel(WireModel):
    """An operator has taken note of a notice, and of all before it that say the same of the same vehicle."""

    notice_id: int
    operator: str = Field(description="The name given at sign-in; empty when no name was given.")
    utc_s: float


class FocusModel(WireModel):
    """The focal plane in use."""

    height_m: float = Field(description="Above the origin.")
    source: FocusSource
    sigma_m: float | None = Field(description="Standard deviation of what autofocus has found.")


class ReplayModel(WireModel):
    """Where a replay is in the recorded mission."""

    time_s: float = Field(description="Since the recording began.")
    duration_s: float
    speed: float = Field(description="Recorded seconds per second.")
    playing: bool


class ReplayPhaseModel(WireModel):
    """When a phase began."""

    time_s: float
    phase: Phase


class ReplayStepModel(WireModel):
    """When a step was decided."""

    time_s: float
    step: int


class ReplayNoticeModel(WireModel):
    """When something happened."""

    time_s: float
    severity: Severity
    text: str
    vehicle_id: int | None


class ReplayFindingModel(WireModel):
    """When a finding was first known, and what became of it at last."""

    time_s: float
    finding_id: int
    status: FindingStatus


class TimelineModel(WireModel):
    """A replay, and what lies where in it."""

    replay: ReplayModel
    start_utc_s: float
    phases: list[ReplayPhaseModel]
    steps: list[ReplayStepModel]
    notices: list[ReplayNoticeModel]
    findings: list[ReplayFindingModel]


class ReplayRequest(WireModel):
    """What is to change in a replay; null leaves it as it is."""

    time_s: Annotated[float, Field(allow_inf_nan=False)] | None = None
    speed: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = None
    playing: bool | None = None


class MissionModel(WireModel):
    """The whole mission at one moment."""

    mission_id: str
    strategy: str
    phase: Phase
    suspension: Suspension
    outcome: Outcome
    message: str
    elapsed_s: float
    step: int
    origin: GeodeticModel | None
    area: list[VertexModel]
    fence: list[VertexModel]
    no_go: list[list[VertexModel]]
    legs: list[ScanLegModel] = Field(description="Of the scan; empty before they are planned.")
    leg: int = Field(description="Index of the leg being flown.")
    covered_percent: float | None = Field(description="Of the search area, in a frame at least once.")
    vehicles: list[VehicleModel]
    preflight: list[PreflightCheckModel]
    target: TargetModel | None = Field(description="The one in view, or else the one that was seen last.")
    targets: list[TargetModel] = Field(description="All that are confirmed, and the target.")
    min_separation_m: float | None
    focus: FocusModel | None
    findings: list[FindingModel] = Field(description="Oldest first.")
    acknowledgements: list[AcknowledgementModel] = Field(
        description="The latest ones, by the number of their notice: the same for all operators."
    )
    replay: ReplayModel | None = Field(description="Of the record that is shown; null for a mission that is flown.")
    allowed_actions: list[Action] = Field(description="What makes sense to offer now; a request can still be refused.")


class FitnessModel(WireModel):
    """One vehicle's share in a step."""

    vehicle_id: int
    fitness: float | None


class MissingModel(WireModel):
    """A vehicle that a step went on without."""

    vehicle_id: int
    reason: str


class WaypointModel(WireModel):
    """One vehicle's planned waypoint of a step, and what safety has made of it."""

    vehicle_id: int
    requested: PositionModel
    sent: PositionModel | None
    verdict: WaypointVerdict
    reason: str


class StepModel(WireModel):
    """One step: what was seen, what was decided."""

    step: int
    elapsed_s: float
    phase: Phase
    visibility_m2: float | None
    threshold_m2: float | None
    branch: str
    evolutionary_factor: float | None
    evolutionary_state: str | None
    c_s_m: float | None
    c_c_m: float | None
    leader_id: int | None
    target: PositionModel | None
    fitness: list[FitnessModel]
    missing: list[MissingModel]
    waypoints: list[WaypointModel]
    imaging_ms: float
    work_ms: float
    loop_lag_p99_ms: float


class NoticeModel(WireModel):
    """Something that happened, for the operator."""

    severity: Severity
    notice_id: int = Field(
        description="Counts from 1 in a mission; a number that is skipped is a notice that was lost."
    )
    text: str
    vehicle_id: int | None
    elapsed_s: float


class AcknowledgeRequest(WireModel):
    """Notices that an operator has taken note of."""

    notice_ids: Annotated[list[Annotated[int, Field(ge=1)]], Field(min_length=1, max_length=200)]


class PictureModel(WireModel):
    """A raster that can be fetched, and where it lies on the ground."""

    kind: PictureKind
    step: int
    url: str
    corners: Annotated[list[VertexModel], Field(min_length=4, max_length=4)] = Field(
        description="North-west, north-east, south-east, south-west."
    )


class ActionRequest(WireModel):
    """An operator's action for the vehicles named, or for the whole mission when ``vehicle_ids`` is null."""

    action: Action
    vehicle_ids: Annotated[list[Annotated[int, Field(ge=1, le=255)]], Field(min_length=1, max_length=255)] | None = None
    focal_height_m: Annotated[float, Field(allow_inf_nan=False)] | None = Field(
        None, description="Of the action focus alone: metres above the origin, or null to leave it to autofocus."
    )


class ActionResultModel(WireModel):
    """What became of an action for one vehicle."""

    vehicle_id: int
    accepted: bool
    text: str


class ActionResponse(WireModel):
    """What became of an action, vehicle by vehicle."""

    action: Action
    results: list[ActionResultModel]


class SessionModel(WireModel):
    """What this client may do."""

    role: Role
    name: str = Field(description="As given at sign-in; empty for observers.")
    sign_in_required: bool = Field(description="False where everybody commands.")


class SignInRequest(WireModel):
    """The operators' code, and who it is that signs in."""

    code: Annotated[str, Field(max_length=200)]
    name: Annotated[str, Field(min_length=1, max_length=40, pattern=r"^\S(.*\S)?$")] = Field(
        description="For the audit log."
    )


class CapabilitiesModel(WireModel):
    """What this service offers beside the mission itself; requests for the rest are refused."""

    planning: bool = Field(description="The plan can be read and changed.")
    viewer: bool = Field(description="Recorded steps can be seen again; findings have pictures.")
    findings: bool = Field(description="Findings can be marked and judged.")


class BasemapModel(WireModel):
    """The map of the ground below everything that flies."""

    url: str | None = Field(description="Of a PMTiles file; null where there is none.")


class ErrorModel(WireModel):
    """The body of every error."""

    id: str = Field(description="Stable, for programs.")
    message: str = Field(description="A sentence for people: what is wrong and what to do.")
