"""The whole mission at one moment."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.groundmap.figures import GroundFigures
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.model.findings import Finding, TargetEstimate
from aos_gcs.mission.model.phase import Outcome, Phase, Suspension
from aos_gcs.mission.model.proposals import ProposalRecord
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.model.steps import FocusSnapshot
from aos_gcs.mission.model.vehicles import VehicleSnapshot


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """An operator has taken note of a notice, and of all before it that say the same of the same vehicle."""

    notice_id: int
    operator: str
    """The name as given at sign-in; empty when no name was given."""
    utc_s: float


@dataclass(frozen=True, slots=True)
class MissionSnapshot:
    """The whole mission at one moment."""

    mission_id: str
    strategy: str
    phase: Phase
    suspension: Suspension
    outcome: Outcome
    message: str
    """Present activity of the mission, in one sentence."""
    elapsed_s: float
    """Clock seconds since the start action; 0 before."""
    step: int
    origin: GeodeticPosition | None
    """Origin of the ENU frame; None until it is known."""
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
    planned_vehicles: int = 0
    """Number of vehicles that fly by the plan; 0 in older records."""
    acknowledgements: tuple[Acknowledgement, ...] = ()
    """The latest ones, by the number of their notice."""
    command_count: int = 0
    """Number of the latest operator's command that was carried out."""
    follows_ground: bool = False
    """Whether the altitude layers follow the ground of an elevation model."""
    started_utc_s: float | None = None
    """Clock time of the start; None before it, in older records and in surveys."""
    sharing: tuple[ChannelStatus, ...] = ()
    """Systems that data is shared with; empty where none is configured, and in older records."""
    proposals: tuple[ProposalRecord, ...] = ()
    """Marks and drawings of others that are proposed for the plan, oldest first."""
    ground: GroundFigures | None = None
    """What has been searched, by the map of it; None before the first figures, and in older records."""
    scan_left_s: float | None = None
    """Time that the rest of the legs takes at the pace so far; None before that is known, and in older records."""
    left_for_later: tuple[LeftPlace, ...] = ()
    """Places that are left for a later look, in the order in which they came into view; empty in older records."""
