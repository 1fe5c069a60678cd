"""Wire models of plans: shapes in degrees, so that a saved plan needs no origin.

Plans are checked in two stages: types and ranges here, and whether they can be flown by ``POST /api/plan/check``, which
reports every problem with its field.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import ConfigDict, Field

from aos_gcs.api.models.base import ScanLegModel, WireModel
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.shape_files import ShapeRole

Latitude = Annotated[float, Field(ge=-90.0, le=90.0)]
Longitude = Annotated[float, Field(ge=-180.0, le=180.0)]


class _FiniteModel(WireModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class PlaceModel(_FiniteModel):
    """A point on the map."""

    latitude_deg: Latitude
    longitude_deg: Longitude


PolygonModel = Annotated[list[PlaceModel], Field(max_length=500)]


class ForestModel(_FiniteModel):
    """Forest that hides the ground; heights are above the focal plane."""

    canopy_height_m: float
    crown_base_m: float
    occluder_size_m: float
    occlusion: float = Field(description="Share of the ground that one image does not see, below 1.")


class PlanModel(_FiniteModel):
    """Search area, no-go zones, launch point, heights and strategy. Fields that are left out take their defaults."""

    vehicles: Annotated[int, Field(ge=1, le=250)]
    area: PolygonModel = Field(default=[])
    no_go: Annotated[list[PolygonModel], Field(max_length=500)] = Field(default=[])
    launch: PlaceModel | None = Field(default=None, description="Known from the vehicles once they are heard.")
    return_point: PlaceModel | None = Field(default=None, description="Null: their launch positions.")
    fence: PolygonModel | None = Field(default=None, description="Null: around area and launch points.")
    scan_heading_deg: Annotated[float, Field(ge=0.0, lt=360.0)] = 0.0
    camera_fov_deg: Annotated[float, Field(gt=1.0, lt=170.0)] = Field(default=50.0, description="Horizontal.")
    lowest_layer_m: Annotated[float, Field(gt=0.0)] = Field(
        default=35.0, description="Height above the origin, like all heights."
    )
    layer_spacing_m: Annotated[float, Field(gt=0.0)] = 3.0
    spacing_m: Annotated[float, Field(gt=0.0)] | None = Field(
        default=None, description="Spacing of the vehicles in line (c4); null: as in the strategy's parameters."
    )
    strategy: str = "aos-apso"
    strategy_parameters: dict[str, Any] = Field(default={})
    floor_m: float | None = None
    ceiling_m: float | None = None
    fence_margin_m: Annotated[float, Field(ge=0.0)] | None = Field(
        default=None, description="Null: the stopping distance at the cruise speed."
    )
    cruise_speed_mps: Annotated[float, Field(gt=0.0)] = 10.0
    search_mode: SearchMode = Field(
        default=SearchSettings().mode,
        strict=False,  # it is text in a request
        description="Flight along the legs while nothing is in view: without stops, or hovering for each frame.",
    )
    search_speed_mps: Annotated[float, Field(gt=0.0)] = Field(
        default=5.0, description="Speed along the legs without stops, at most the cruise speed."
    )
    rate_hz: Annotated[float, Field(gt=0.0)] = Field(
        default=2.0, description="Frames per second of each camera along the legs without stops."
    )
    pod_percent: Annotated[float, Field(gt=0.0, lt=100.0)] | None = Field(
        default=None,
        description="Wanted probability of detection of a standing person, a mean over the area; null: none is wanted.",
    )
    line_spacing_m: Annotated[float, Field(gt=0.0)] | None = Field(
        default=None, description="Spacing of the vehicles in line along the legs; null: as for a close look."
    )
    leg_spacing_m: Annotated[float, Field(gt=0.0)] | None = Field(
        default=None, description="Greatest distance of neighbouring legs; null: as wide as the swarm's line sees."
    )
    passes: Annotated[int, Field(ge=1)] = Field(default=1, description="Times that all legs are flown, to and fro.")
    split: bool = Field(
        default=SearchSettings().split,
        description=(
            "Whether vehicles that are not needed for a close look scan on, along the legs without stops; left out: as "
            "the mission is set."
        ),
    )
    battery_reserve_percent: Annotated[float, Field(ge=0.0, lt=90.0)] = 20.0
    endurance_min: Annotated[float, Field(gt=0.0)] = Field(default=25.0, description="Flight time of a full battery.")
    search_min: Annotated[float, Field(gt=0.0)] = Field(
        default=20.0, description="Time from the start after which all vehicles return if nothing was found."
    )
    forest: ForestModel | None = Field(
        default=None, description="Forest for the proposals of spacing and number of vehicles."
    )


class StrategyParameterModel(WireModel):
    """A parameter of a strategy, as the strategy declares it."""

    name: str = Field(description="Name in PlanModel's strategy_parameters.")
    text: str = Field(description="Effect of the parameter.")
    unit: str
    default: float | bool | None
    is_switch: bool = Field(description="True or false; else a number.")
    is_optional: bool = Field(description="May be null.")
    above: float | None
    at_least: float | None
    below: float | None
    at_most: float | None


class StrategyModel(WireModel):
    """A strategy that a plan can use."""

    name: str
    parameters: list[StrategyParameterModel] = Field(
        description="Parameters without the spacing, which is a field of the plan."
    )


class PlanProblemModel(WireModel):
    """A problem to fix, or advice."""

    field: str = Field(description="Field of PlanModel, with the part of it: no_go[0], strategy_parameters.gamma.")
    text: str
    blocking: bool = Field(description="False for advice: the plan can be flown.")


class PlanProposalModel(WireModel):
    """Another value for one field, and why."""

    field: str
    value: float
    reason: str


class PredictedDetectionModel(WireModel):
    """Probability of detection, a mean over the search area, by the posture of the person."""

    standing: float
    sitting: float
    lying: float


class PlanEstimateModel(WireModel):
    """Estimate for a plan when nothing is found."""

    legs: list[ScanLegModel]
    swath_m: float = Field(description="Width that the swarm's line sees.")
    area_m2: float
    free_area_m2: float = Field(description="Search area without the no-go zones.")
    covered_percent: float = Field(description="Share of the whole area.")
    path_m: float
    scan_s: float
    hectares_per_hour: float = Field(description="Part of the search area that is swept per time of the whole flight.")
    flight_s: float = Field(description="From the first take-off to the last landing.")
    battery_percent: float = Field(description="Share of a full battery.")
    climb_m: float = Field(description="Climbs of the highest vehicle, added up.")
    detection_percent: PredictedDetectionModel | None = Field(
        description="Expected probability of detection; null without a forest, and where the swarm stops for images."
    )


class LegProfileModel(WireModel):
    """Heights above the origin along one leg, as lists of the same length; null where the ground is not known."""

    distance_m: list[float] = Field(description="Distances from the start of the leg.")
    lowest_ground_m: list[float | None] = Field(description="Lowest ground below the whole line of the swarm.")
    highest_ground_m: list[float | None]
    surface_m: list[float] = Field(description="Surface that the altitude layers are offset from; 0 if they are level.")
    floor_m: list[float | None] = Field(description="Floor above the ground; above the origin without a model of it.")
    ceiling_m: list[float | None]


class PlanReportModel(WireModel):
    """Assessment of a plan."""

    flyable: bool
    problems: list[PlanProblemModel]
    proposals: list[PlanProposalModel]
    estimate: PlanEstimateModel | None = Field(description="Null while a problem is blocking.")
    profile: list[LegProfileModel] = Field(description="Profile of each leg; empty while a shape or number is wrong.")
    canopy_height_m: float | None = Field(description="Height of the canopy above the ground, where the plan has one.")
    fence: list[PlaceModel] = Field(
        description="Geofence: the plan's, or the one proposed, of any number of corners; empty without area."
    )
    layers_m: list[float] = Field(description="Height of each vehicle's layer.")
    stopping_distance: str = Field(description="Geofence margin where the plan gives none, and how it is made up.")


class ImportedShapeModel(WireModel):
    """A polygon or a point of a file."""

    role: ShapeRole = Field(description="Likely role.")
    name: str
    places: list[PlaceModel]


class SavedPlanModel(WireModel):
    """A plan in the folder."""

    name: str
    saved_utc_s: float
    version: str = Field(description="Changes whenever the plan is saved; for `replaces`.")
