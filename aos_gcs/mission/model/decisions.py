"""Decisions of a search, and what each depended on besides its frames: enough to compute it again from the record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.plans import TrafficSituation
from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.mission.model.findings import Finding, TargetEstimate
from aos_gcs.mission.model.phase import Phase
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.swarm.model import Diagnostics


class Group(StrEnum):
    """Part of a swarm of which some vehicles look closely while the others scan on."""

    LOOK = "look"
    SCAN = "scan"


@dataclass(frozen=True, slots=True)
class LeftPlace:
    """A place that was in view and is left for a later look."""

    place_enu_m: tuple[float, float]
    probability: float
    """Probability that it is a person, by what has been seen of it."""


@dataclass(frozen=True, slots=True)
class SearchRecord:
    """What all steps of a search have in common."""

    settings: MissionSettings
    origin: GeodeticPosition
    """Origin of the mission's frame."""
    left_for_later: tuple[LeftPlace, ...] = ()
    """Places that the former sortie has left for later, or the station before, where its flight was taken up."""


@dataclass(frozen=True, slots=True)
class FormedLine:
    """A line that was formed before a step."""

    legs: tuple[ScanLeg, ...]
    """Legs of the whole scan."""
    leg: int
    """Index of the one that the line was formed on."""
    formed: ScanLeg
    """The rest of that leg."""


@dataclass(frozen=True, slots=True)
class SwarmPlace:
    """A vehicle of the swarm at the time of a decision."""

    vehicle_id: int
    position_enu_m: EnuPoint
    """Position; where its frame was exposed in flight, the place of that."""
    layer_height_m: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Situation:
    """State of the flight at the time of a decision."""

    now_s: float
    """Mission time."""
    swarm: tuple[SwarmPlace, ...]
    traffic: TrafficSituation

    @property
    def positions_enu_m(self) -> NDArray[np.float64]:
        """Positions of the swarm, shape (n, 3)."""
        return np.array([one.position_enu_m for one in self.swarm])


@dataclass(frozen=True, slots=True)
class Decision:
    """Decision of a step."""

    following: Phase
    diagnostics: Diagnostics
    waypoints: tuple[WaypointRecord, ...]
    """Vetted, not sent yet."""
    is_sweep: bool = False
    """Whether the swarm flies on along the leg, so that nobody waits for its arrival."""


@dataclass(frozen=True, slots=True, eq=False)
class DecisionRecord:
    """A step's decision: what it depended on besides the frames, and what only the frames led to."""

    step: int
    phase: Phase
    """Phase in which the step was made."""
    decided: int
    """Number of decisions of this search before it."""
    concluded: int
    """Number of conclusions of this search before it."""
    focal_height_m: float
    settled_enu_m: tuple[tuple[float, float], ...]
    """Places that lead no vehicle any more."""
    situation: Situation
    following: Phase
    """Phase that the decision led to; a conclusion may change it."""
    marks: Mapping[int, str]
    """Digest of the cells that the frame of each vehicle marks."""
    line: FormedLine | None = None
    """The line formed since the decision before; None if there was none."""
    poses: Mapping[int, Pose] = field(default_factory=dict)
    """Poses as corrected by registration, by vehicle; empty where it is off."""
    edits_before_analysis: tuple[Finding, ...] = ()
    """Findings as operators have changed them since the step before, in order."""
    edits: tuple[Finding, ...] = ()
    """Findings that operators have changed while the frames were analysed."""
    may_sweep: bool = False
    """Whether the swarm may fly along the leg without stops."""
    speeds_mps: Mapping[int, float] = field(default_factory=dict)
    """Speed of each vehicle at exposure, by id; empty where all hovered."""
    group: Group | None = None
    """Group whose step it was; None: the whole swarm."""


@dataclass(frozen=True, slots=True)
class ConclusionRecord:
    """What was concluded about the targets of a step, once its frames were judged."""

    step: int
    now_s: float
    """Mission time."""
    judged: bool
    """Whether the frames could be judged."""
    following: Phase
    """Phase that follows."""
    targets: tuple[TargetEstimate, ...]
    """All confirmed targets and the present one."""
    edits: tuple[Finding, ...] = ()
    """Findings as operators have changed them since the decision, in order."""
