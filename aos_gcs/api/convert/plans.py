"""Conversion of plans between the wire, in degrees, and the core, in metres about the mission's origin."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.airspace.stopping import StoppingDistance
from aos_gcs.api.convert.places import rounded, scan_leg
from aos_gcs.api.models import plans as wire
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import SEA_LEVEL
from aos_gcs.groundmap.figures import DetectionFigures
from aos_gcs.mission.model.vehicles import VehicleSnapshot
from aos_gcs.planning.checks.advice import ProposedValue
from aos_gcs.planning.estimate import PlanEstimate
from aos_gcs.planning.plan import MissionPlan, PlanProblem, StrategyOptions
from aos_gcs.planning.proposal import altitude_layers
from aos_gcs.planning.settings import ForestSettings, MissionSettings
from aos_gcs.planning.shape_files import ImportedShape
from aos_gcs.planning.terrain.profile import LegProfile

NO_ORIGIN: Final = GeodeticPosition(0.0, 0.0, SEA_LEVEL)
"""Stand-in for the origin of plans without any position."""
_PROFILE_DIGITS: Final = 1
"""Decimals of metres in a profile."""

_WIRE_NAMES: Final = {
    "area_enu_m": "area",
    "no_go_enu_m": "no_go",
    "launch_enu_m": "launch",
    "return_enu_m": "return_point",
    "fence_enu_m": "fence",
    "scan_heading_rad": "scan_heading_deg",
    "camera_fov_rad": "camera_fov_deg",
    "min_battery_fraction": "battery_reserve_percent",
    "pod": "pod_percent",
    "endurance_s": "endurance_min",
    "search_s": "search_min",
}
"""Names of the core's fields in requests and answers, where they differ."""


_LEFT_TO_MISSION: Final = frozenset({"split"})
"""Fields that a plan may leave to the settings of the mission: plans of earlier versions do not have them."""


@dataclass(frozen=True, slots=True)
class PlanPicture:
    """What a plan looks like, whether it can be flown or not."""

    profile: tuple[LegProfile, ...]
    """Profile of each leg."""
    fence_enu_m: Polygon
    """Geofence, of the plan or as proposed; empty while there is none."""


def plan_origin(plan: wire.PlanModel, origin: GeodeticPosition | None) -> GeodeticPosition:
    """Return the mission's origin or, while it is unknown, a position of the plan in its stead."""
    if origin is not None:
        return origin
    places = [place for place in (plan.launch, *plan.area) if place is not None]
    if not places:
        return NO_ORIGIN
    return GeodeticPosition(places[0].latitude_deg, places[0].longitude_deg, SEA_LEVEL)


def homes(vehicles: Iterable[VehicleSnapshot], origin: GeodeticPosition | None) -> dict[int, tuple[float, float]]:
    """Return the vehicles' homes by id, horizontal ENU metres; empty while the origin is unknown."""
    if origin is None:
        return {}
    frame, places = LocalFrame(origin), {}
    for vehicle in vehicles:
        if vehicle.telemetry.home is not None:
            east_m, north_m, _ = frame.to_enu(vehicle.telemetry.home)
            places[vehicle.telemetry.vehicle_id] = (float(east_m), float(north_m))
    return places


def left_open(plan: wire.PlanModel) -> set[str]:
    """Return the fields that a plan leaves to the mission."""
    return set(_LEFT_TO_MISSION - plan.model_fields_set)


def complete(plan: wire.PlanModel, settings: MissionSettings) -> wire.PlanModel:
    """Return a plan that leaves nothing to the settings of the mission."""
    return plan.model_copy(update={name: getattr(settings.search, name) for name in left_open(plan)})


def plan_from_wire(plan: wire.PlanModel, origin: GeodeticPosition) -> MissionPlan:
    """Convert a plan."""
    frame = LocalFrame(origin)

    def point(place: wire.PlaceModel) -> tuple[float, float]:
        position = GeodeticPosition(place.latitude_deg, place.longitude_deg, origin.altitude_amsl_m)
        east_m, north_m, _ = frame.to_enu(position)
        return float(east_m), float(north_m)

    def polygon(places: Sequence[wire.PlaceModel]) -> Polygon:
        return tuple(point(place) for place in places)

    return MissionPlan(
        vehicles=plan.vehicles,
        area_enu_m=polygon(plan.area),
        no_go_enu_m=tuple(polygon(zone) for zone in plan.no_go),
        launch_enu_m=point(plan.launch) if plan.launch else None,
        return_enu_m=point(plan.return_point) if plan.return_point else None,
        fence_enu_m=polygon(plan.fence) if plan.fence is not None else None,
        scan_heading_rad=math.radians(plan.scan_heading_deg),
        camera_fov_rad=math.radians(plan.camera_fov_deg),
        lowest_layer_m=plan.lowest_layer_m,
        layer_spacing_m=plan.layer_spacing_m,
        spacing_m=plan.spacing_m,
        strategy=plan.strategy,
        strategy_parameters=plan.strategy_parameters,
        floor_m=plan.floor_m,
        ceiling_m=plan.ceiling_m,
        fence_margin_m=plan.fence_margin_m,
        cruise_speed_mps=plan.cruise_speed_mps,
        search_mode=plan.search_mode,
        search_speed_mps=plan.search_speed_mps,
        rate_hz=plan.rate_hz,
        pod=None if plan.pod_percent is None else plan.pod_percent / 100.0,
        line_spacing_m=plan.line_spacing_m,
        leg_spacing_m=plan.leg_spacing_m,
        passes=plan.passes,
        split=plan.split,
        min_battery_fraction=plan.battery_reserve_percent / 100.0,
        endurance_s=60.0 * plan.endurance_min,
        search_s=60.0 * plan.search_min,
        forest=ForestSettings(**plan.forest.model_dump()) if plan.forest else None,
    )


def plan_to_wire(plan: MissionPlan, origin: GeodeticPosition) -> wire.PlanModel:
    """Convert a plan."""
    frame = LocalFrame(origin)

    def place(point_enu_m: tuple[float, float]) -> wire.PlaceModel:
        return _place(frame, point_enu_m)

    def ring(polygon_enu_m: Polygon) -> list[wire.PlaceModel]:
        return [place(point_enu_m) for point_enu_m in polygon_enu_m]

    forest = plan.forest
    return wire.PlanModel(
        vehicles=plan.vehicles,
        area=ring(plan.area_enu_m),
        no_go=[ring(zone) for zone in plan.no_go_enu_m],
        launch=place(plan.launch_enu_m) if plan.launch_enu_m else None,
        return_point=place(plan.return_enu_m) if plan.return_enu_m else None,
        fence=ring(plan.fence_enu_m) if plan.fence_enu_m is not None else None,
        scan_heading_deg=math.degrees(plan.scan_heading_rad) % 360.0,
        camera_fov_deg=math.degrees(plan.camera_fov_rad),
        lowest_layer_m=plan.lowest_layer_m,
        layer_spacing_m=plan.layer_spacing_m,
        spacing_m=plan.spacing_m,
        strategy=plan.strategy,
        strategy_parameters=dict(plan.strategy_parameters),
        floor_m=plan.floor_m,
        ceiling_m=plan.ceiling_m,
        fence_margin_m=plan.fence_margin_m,
        cruise_speed_mps=plan.cruise_speed_mps,
        search_mode=plan.search_mode,
        search_speed_mps=plan.search_speed_mps,
        rate_hz=plan.rate_hz,
        pod_percent=None if plan.pod is None else 100.0 * plan.pod,
        line_spacing_m=plan.line_spacing_m,
        leg_spacing_m=plan.leg_spacing_m,
        passes=plan.passes,
        split=plan.split,
        battery_reserve_percent=100.0 * plan.min_battery_fraction,
        endurance_min=plan.endurance_s / 60.0,
        search_min=plan.search_s / 60.0,
        forest=wire.ForestModel(
            canopy_height_m=forest.canopy_height_m,
            crown_base_m=forest.crown_base_m,
            occluder_size_m=forest.occluder_size_m,
            occlusion=forest.occlusion,
        )
        if forest
        else None,
    )


def report(
    plan: MissionPlan,
    problems: Sequence[PlanProblem],
    proposals: Sequence[ProposedValue],
    estimate: PlanEstimate | None,
    *,
    picture: PlanPicture,
    origin: GeodeticPosition,
) -> wire.PlanReportModel:
    """Convert the assessment of a plan."""
    frame = LocalFrame(origin)
    return wire.PlanReportModel(
        flyable=estimate is not None,
        problems=[
            wire.PlanProblemModel(field=_wire_name(one.field), text=one.text, blocking=one.blocking) for one in problems
        ],
        proposals=[_proposal(one) for one in proposals],
        estimate=_estimate(estimate, origin) if estimate else None,
        profile=[_leg_profile(one) for one in picture.profile],
        canopy_height_m=plan.forest.canopy_height_m if plan.forest else None,
        fence=[_place(frame, corner_m) for corner_m in picture.fence_enu_m],
        layers_m=list(altitude_layers(plan.vehicles, plan.lowest_layer_m, plan.layer_spacing_m)),
        stopping_distance=str(StoppingDistance(plan.cruise_speed_mps)),
    )


def _place(frame: LocalFrame, point_enu_m: tuple[float, float]) -> wire.PlaceModel:
    position = frame.to_geodetic((*point_enu_m, 0.0))
    return wire.PlaceModel(latitude_deg=position.latitude_deg, longitude_deg=position.longitude_deg)


def _leg_profile(profile: LegProfile) -> wire.LegProfileModel:
    def heights(values_m: NDArray[np.float64]) -> list[float | None]:
        return [rounded(value_m, _PROFILE_DIGITS) for value_m in values_m.tolist()]

    return wire.LegProfileModel(
        distance_m=profile.distances_m.round(_PROFILE_DIGITS).tolist(),
        lowest_ground_m=heights(profile.lowest_ground_m),
        highest_ground_m=heights(profile.highest_ground_m),
        surface_m=profile.surface_m.round(_PROFILE_DIGITS).tolist(),
        floor_m=heights(profile.floor_m),
        ceiling_m=heights(profile.ceiling_m),
    )


def _proposal(proposal: ProposedValue) -> wire.PlanProposalModel:
    value = math.degrees(proposal.value) if proposal.field.endswith("_rad") else proposal.value
    return wire.PlanProposalModel(field=_wire_name(proposal.field), value=value, reason=proposal.reason)


def _estimate(estimate: PlanEstimate, origin: GeodeticPosition) -> wire.PlanEstimateModel:
    return wire.PlanEstimateModel(
        legs=[scan_leg(leg.start_enu_m, leg.end_enu_m, origin) for leg in estimate.legs],
        swath_m=estimate.swath_m,
        area_m2=estimate.area_m2,
        free_area_m2=estimate.free_area_m2,
        covered_percent=100.0 * estimate.covered_fraction,
        path_m=estimate.path_m,
        scan_s=estimate.scan_s,
        hectares_per_hour=estimate.hectares_per_hour,
        flight_s=estimate.flight_s,
        battery_percent=100.0 * estimate.battery_fraction,
        climb_m=estimate.climb_m,
        detection_percent=_detection(estimate.detection) if estimate.detection else None,
    )


def _detection(figures: DetectionFigures) -> wire.PredictedDetectionModel:
    return wire.PredictedDetectionModel(
        standing=100.0 * figures.standing, sitting=100.0 * figures.sitting, lying=100.0 * figures.lying
    )


def strategy(options: StrategyOptions) -> wire.StrategyModel:
    """Convert the parameters of a strategy."""
    return wire.StrategyModel(
        name=options.name,
        parameters=[
            wire.StrategyParameterModel(
                name=one.name,
                text=one.text,
                unit=one.unit,
                default=one.default,
                is_switch=one.is_switch,
                is_optional=one.is_optional,
                **asdict(one.bounds),
            )
            for one in options.parameters
        ],
    )


def imported(shape: ImportedShape) -> wire.ImportedShapeModel:
    """Convert an imported shape."""
    return wire.ImportedShapeModel(
        role=shape.role,
        name=shape.name,
        places=[
            wire.PlaceModel(latitude_deg=place.latitude_deg, longitude_deg=place.longitude_deg)
            for place in shape.places
        ],
    )


def _wire_name(field: str) -> str:
    return re.sub(r"^\w+", lambda match: _WIRE_NAMES.get(match[0], match[0]), field)
