"""Wire models of steps and their rasters."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.airspace.waypoints import WaypointVerdict
from aos_gcs.api.models.base import PositionModel, VertexModel, WireModel
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import PictureKind


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


class StepFiguresModel(WireModel):
    """What a step says of the search as a whole, of the same size for any number of vehicles."""

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
    imaging_ms: float
    work_ms: float
    loop_lag_p99_ms: float


class StepModel(StepFiguresModel):
    """One step: what was seen, what was decided."""

    target: PositionModel | None
    fitness: list[FitnessModel]
    missing: list[MissingModel]
    waypoints: list[WaypointModel]


class PictureModel(WireModel):
    """A raster that can be fetched, and where it lies on the ground."""

    kind: PictureKind
    step: int
    url: str
    corners: Annotated[list[VertexModel], Field(min_length=4, max_length=4)] = Field(
        description="North-west, north-east, south-east, south-west."
    )
