"""Checks of a plan against the ground: its legs, and the ways home from everywhere in the search area."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface
from aos_gcs.airspace.stopping import POSITION_ERROR_M
from aos_gcs.airspace.terrain import GroundCells, GroundRaster
from aos_gcs.elevation.geoid import Geoid
from aos_gcs.elevation.likely_cause import likely_cause
from aos_gcs.elevation.model import SURFACE_WARNING, ModelKind
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.planning.checks.sites import Homes, planned_boundaries
from aos_gcs.planning.estimate import launch_place, planned_legs
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan, PlanProblem
from aos_gcs.planning.proposal import propose_fence, proposed_floor_m
from aos_gcs.planning.settings import MissionSettings, TerrainSettings
from aos_gcs.planning.terrain.ground import (
    EnuBounds,
    floor_above_ground_m,
    ground_heights_m,
    ground_in_fence,
    ground_within,
    open_model,
)
from aos_gcs.planning.terrain.layer_surface import layer_surface
from aos_gcs.planning.terrain.suspected_holes import suspected_holes

FloatArray = NDArray[np.float64]

MAX_ALTITUDE_ERROR_M = 10.0
"""Greatest difference between the altitude of a place on the ground and the elevation model."""
_MARGIN_M = 50.0


@dataclass(frozen=True, slots=True)
class HeightBand:
    """Heights above the ground that vehicles keep, and those above the origin at which they fly."""

    floor_m: float
    ceiling_m: float
    lowest_layer_m: float
    highest_layer_m: float
    surface: ReferenceSurface = LEVEL
    """Surface that the layers are offset from."""


@dataclass(frozen=True, slots=True)
class PlannedRelief:
    """Ground below a plan, as its vehicles see it, and the heights above it."""

    ground: GroundRaster
    band: HeightBand


@dataclass(frozen=True, slots=True)
class TerrainConflict:
    """A place at which a plan meets the ground's limits."""

    field: str
    """Field of the plan that helps."""
    text: str


def surface_warning(terrain: TerrainSettings) -> str | None:
    """Return what the user of a surface model is told; None for a terrain model."""
    return SURFACE_WARNING if terrain.kind is ModelKind.SURFACE else None


def check_terrain(
    plan: MissionPlan,
    settings: MissionSettings,
    origin: GeodeticPosition | None,
    homes_enu_m: Homes,
    legs: Sequence[ScanLeg],
) -> Iterator[PlanProblem]:
    """Yield what brings a plan too close to the ground or too far above it, and where the ground is not known.

    Problems of where vehicles stand are advice: they can still be moved, and preflight checks them again.
    """
    terrain, origin = settings.terrain, settings.origin or origin
    if terrain is None:
        return
    if (warning := surface_warning(terrain)) is not None:
        yield PlanProblem("lowest_layer_m", warning, blocking=False)
    if origin is None:
        return
    try:
        is_reported = settings.origin is None
        yield from _problems(plan, terrain, origin, homes_enu_m, legs, is_reported=is_reported)
    except (ConfigurationError, InputDataError) as error:
        yield PlanProblem("area_enu_m", str(error))


def _problems(
    plan: MissionPlan,
    terrain: TerrainSettings,
    origin: GeodeticPosition,
    homes_enu_m: Homes,
    legs: Sequence[ScanLeg],
    *,
    is_reported: bool,
) -> Iterator[PlanProblem]:
    """Yield the problems; ``is_reported``: a vehicle has reported the origin, so that its altitude may err."""
    points = {"launch_enu_m": launch_place(plan), "return_enu_m": plan.return_enu_m}
    planned = {field: point for field, point in points.items() if point is not None}
    heights_m = ground_heights_m(terrain, origin, np.array([(0.0, 0.0), *planned.values()]))
    frame, level_m = LocalFrame(origin), float(heights_m[0])
    bare = dict(zip(planned, heights_m[1:], strict=True))
    barred = list(_check_points(frame, planned, bare, 0.0 if is_reported else level_m, open_model(terrain).geoid))
    yield from barred
    if barred:
        return
    relief = planned_relief(plan, terrain, origin, homes_enu_m, legs, is_reported=is_reported)
    if (warning := suspected_holes(relief.ground, frame, max(open_model(terrain).cell_m))) is not None:
        yield PlanProblem("area_enu_m", warning, blocking=False)
    conflicts = list(_conflicts(relief.ground, frame, _planned_outlines(plan, legs), relief.band))
    yield from (PlanProblem(conflict.field, conflict.text) for conflict in conflicts)
    if not conflicts:
        for conflict in _conflicts(relief.ground, frame, _ways(plan, list(homes_enu_m.values())), relief.band):
            yield PlanProblem(conflict.field, conflict.text, blocking=False)


def planned_relief(
    plan: MissionPlan,
    terrain: TerrainSettings,
    origin: GeodeticPosition,
    homes_enu_m: Homes,
    legs: Sequence[ScanLeg],
    *,
    is_reported: bool,
) -> PlannedRelief:
    """Return the ground below all that a plan flies over, and the heights of its layers and limits.

    Args:
        plan: plan with valid shapes.
        terrain: elevation model.
        origin: origin of the plan.
        homes_enu_m: launch points of the vehicles that are heard already.
        legs: legs of the plan.
        is_reported: whether a vehicle has reported the origin: the ground there then counts as level with it.

    Raises:
        ConfigurationError: a setting cannot be used, or a library is missing.
        InputDataError: a file cannot be used or read.
    """
    outlines = [_planned_outlines(plan, legs), _ways(plan, list(homes_enu_m.values()))]
    corners_m = np.vstack([corner_m for each in outlines for shapes in each.values() for corner_m in shapes])
    ground = ground_within(terrain, origin, EnuBounds.around(corners_m, _MARGIN_M))
    if is_reported:
        level_m = float(ground_heights_m(terrain, origin, np.zeros((1, 2)))[0])
        ground = replace(ground, offsets_m=(-level_m, -level_m))
    surface = _planned_surface(plan, terrain, origin, homes_enu_m, ground.offsets_m)
    return PlannedRelief(ground, _band(plan, terrain, surface))


def _planned_outlines(plan: MissionPlan, legs: Sequence[ScanLeg]) -> dict[str, list[FloatArray]]:
    """Return the outlines, by name, of what the plan itself flies over."""
    return _flown(plan, legs, [point for point in (launch_place(plan), plan.return_enu_m) if point is not None])


def flown_conflicts(
    plan: MissionPlan,
    terrain: TerrainSettings,
    frame: LocalFrame,
    ground: GroundRaster,
    *,
    homes_enu_m: Sequence[tuple[float, float]],
    legs: Sequence[ScanLeg],
    surface: ReferenceSurface,
) -> list[TerrainConflict]:
    """Return what brings a flight from known launch points too close to the ground, too far above it, or off the model.

    Args:
        plan: what is flown.
        terrain: limits above the ground.
        frame: local frame.
        ground: ground as the vehicles see it that stand on it.
        homes_enu_m: their launch points.
        legs: legs of the plan.
        surface: surface that the altitude layers are offset from.
    """
    points = [*homes_enu_m, *(() if plan.return_enu_m is None else (plan.return_enu_m,))]
    return list(_conflicts(ground, frame, _flown(plan, legs, points), _band(plan, terrain, surface)))


def highest_flown_ground_m(
    plan: MissionPlan, settings: MissionSettings, points_enu_m: Sequence[tuple[float, float]]
) -> float:
    """Return the highest known ground, above the origin, below all that vehicles fly over from some launch points.

    Raises:
        ConfigurationError: the settings name no elevation model or origin, or none of the ground is known.
        InputDataError: a file cannot be used or read.
    """
    terrain, origin = settings.terrain, settings.origin
    if terrain is None or origin is None:
        raise ConfigurationError("The ground below a plan is known by an elevation model and an origin only.")
    outlines = _flown(plan, planned_legs(plan, settings.imaging.plane_height_m), points_enu_m)
    shapes = [shape_m for each in outlines.values() for shape_m in each]
    ground = ground_within(terrain, origin, EnuBounds.around(np.vstack(shapes), _MARGIN_M))
    highest_m = ground.within(shapes).highest_m
    if np.isnan(highest_m).all():
        raise ConfigurationError(f"{', '.join(terrain.files)}: the ground below the mission is not known.")
    return float(np.nanmax(highest_m))


def _flown(
    plan: MissionPlan, legs: Sequence[ScanLeg], points_enu_m: Sequence[tuple[float, float]]
) -> dict[str, list[FloatArray]]:
    """Return the outlines, by name, of what vehicles fly over."""
    scanned = [ways_m(plan, []), *(swept_m(plan, leg) for leg in legs)]
    return {"Search area": scanned, **_ways(plan, points_enu_m)}


def _ways(plan: MissionPlan, points_enu_m: Sequence[tuple[float, float]]) -> dict[str, list[FloatArray]]:
    return {"Way to the search area or home": [ways_m(plan, points_enu_m)]} if points_enu_m else {}


def _check_points(
    frame: LocalFrame,
    points_enu_m: Mapping[str, tuple[float, float]],
    heights_m: Mapping[str, float],
    level_m: float,
    geoid: Geoid | None,
) -> Iterator[PlanProblem]:
    """Yield the points below which the ground is not known, and an origin that is ``level_m`` below the ground."""
    for field, point in points_enu_m.items():
        if math.isnan(heights_m[field]):
            where = f"The {field.partition('_')[0]} point at {place_text(frame, point)}"
            text = f"{where} is where the elevation model has a hole or ends. Move it, or add a file that covers it."
            yield PlanProblem(field, text)
    if (misfit := origin_misfit(frame.origin, level_m, geoid)) is not None:
        yield PlanProblem("launch_enu_m", misfit)


def origin_misfit(origin: GeodeticPosition, level_m: float, geoid: Geoid | None) -> str | None:
    """Return what is wrong with an origin that is ``level_m`` below the ground of the model; None where nothing is.

    Args:
        origin: origin of a plan.
        level_m: height of the ground above it, by the elevation model.
        geoid: geoid, where its grid is at hand.
    """
    if not abs(level_m) > MAX_ALTITUDE_ERROR_M:
        return None
    origin_m = origin.altitude_amsl_m
    undulation_m = None if geoid is None else float(geoid.undulation_m(origin.latitude_deg, origin.longitude_deg))
    cause = likely_cause(origin_m + level_m, origin_m, undulation_m)
    return (
        f"The origin's altitude of {origin_m:.1f} m differs by {abs(level_m):.1f} m from the elevation model, "
        f"which has {origin_m + level_m:.1f} m there; {MAX_ALTITUDE_ERROR_M:g} m are allowed"
        f"{f' ({cause})' if cause else ''}: correct it, or the model's vertical datum or unit."
    )


def _planned_surface(
    plan: MissionPlan,
    terrain: TerrainSettings,
    origin: GeodeticPosition,
    homes_enu_m: Homes,
    offsets_m: tuple[float, float],
) -> ReferenceSurface:
    """Return the surface that the layers of a plan are offset from, over the ground of its whole geofence."""
    if not terrain.follow:
        return LEVEL
    limits = planned_boundaries(plan, homes_enu_m)
    ground = replace(ground_in_fence(terrain, origin, limits), offsets_m=offsets_m)
    return layer_surface(terrain, ground, limits, plan.cruise_speed_mps)


def _band(plan: MissionPlan, terrain: TerrainSettings, surface: ReferenceSurface) -> HeightBand:
    floor_m = proposed_floor_m(plan.lowest_layer_m) if plan.floor_m is None else plan.floor_m
    floor_m = floor_above_ground_m(terrain, plan.forest, floor_m)
    return HeightBand(floor_m, terrain.ceiling_above_ground_m, plan.lowest_layer_m, plan.highest_layer_m, surface)


def _conflicts(
    ground: GroundRaster, frame: LocalFrame, outlines: Mapping[str, Sequence[FloatArray]], band: HeightBand
) -> Iterator[TerrainConflict]:
    """Yield the worst conflict of each kind within named outlines; the first that has it names it."""
    cells = {name: ground.within(outlines_m) for name, outlines_m in outlines.items()}
    for judge in (_unknown, _too_low, _too_high):
        found = [conflict for name, each in cells.items() if (conflict := judge(name, each, frame, band)) is not None]
        if found:
            worst = max(found, key=lambda one: one[0])
            yield worst[1]


def _unknown(
    name: str, cells: GroundCells, frame: LocalFrame, _band: HeightBand
) -> tuple[float, TerrainConflict] | None:
    unknown = np.isnan(cells.highest_m)
    if not unknown.any():
        return None
    first_m = cells.places_enu_m[int(np.argmax(unknown))]
    text = (
        f"{name}: the ground is not known at {place_text(frame, first_m)}, where the elevation model has a hole or "
        f"ends, and over {unknown.mean():.1%} of it in all. Keep clear of it, or add a file that covers it."
    )
    return float(unknown.mean()), TerrainConflict("area_enu_m", text)


def _too_low(
    name: str, cells: GroundCells, frame: LocalFrame, band: HeightBand
) -> tuple[float, TerrainConflict] | None:
    surface_m = band.surface.height_m(cells.places_enu_m)
    clearance_m = band.lowest_layer_m + surface_m - cells.highest_m
    if np.isnan(clearance_m).all() or np.nanmin(clearance_m) >= band.floor_m:
        return None
    at = int(np.nanargmin(clearance_m))
    ground_m, missing_m = float(cells.highest_m[at]), band.floor_m - float(clearance_m[at])
    text = (
        f"{name}: at {place_text(frame, cells.places_enu_m[at])} the ground rises to {ground_m:.1f} m above the "
        f"origin. The lowest layer of {band.lowest_layer_m:g} m is {clearance_m[at]:.1f} m above it, {missing_m:.1f} m "
        f"below the floor of {band.floor_m:g} m above ground: raise it to "
        f"{math.ceil(ground_m - surface_m[at] + band.floor_m):d} m or more."
    )
    return missing_m, TerrainConflict("lowest_layer_m", text)


def _too_high(
    name: str, cells: GroundCells, frame: LocalFrame, band: HeightBand
) -> tuple[float, TerrainConflict] | None:
    height_m = band.highest_layer_m + band.surface.height_m(cells.places_enu_m) - cells.lowest_m
    if np.isnan(height_m).all() or np.nanmax(height_m) <= band.ceiling_m:
        return None
    at = int(np.nanargmax(height_m))
    excess_m = float(height_m[at]) - band.ceiling_m
    text = (
        f"{name}: at {place_text(frame, cells.places_enu_m[at])} the ground is at {cells.lowest_m[at]:.1f} m above the "
        f"origin. The highest layer of {band.highest_layer_m:g} m is {height_m[at]:.1f} m above it, {excess_m:.1f} m "
        f"beyond the ceiling of {band.ceiling_m:g} m above ground: lower the layers or their spacing, or leave the "
        "place out."
    )
    return excess_m, TerrainConflict("ceiling_m", text)


def swept_m(plan: MissionPlan, leg: ScanLeg) -> FloatArray:
    """Return the corners of the ground that the swarm's line passes over on a leg, shape (4, 2)."""
    spacing_m = plan.on_legs_m
    start_m, end_m = np.array(leg.start_enu_m), np.array(leg.end_enu_m)
    half_m = (plan.vehicles - 1) / 2.0 * spacing_m + POSITION_ERROR_M
    east, north = leg.direction_enu
    along, across = np.array((east, north)), np.array((-north, east))
    start_m, end_m = start_m - POSITION_ERROR_M * along, end_m + POSITION_ERROR_M * along
    return np.array(
        (start_m - half_m * across, start_m + half_m * across, end_m + half_m * across, end_m - half_m * across)
    )


def ways_m(plan: MissionPlan, points_enu_m: Sequence[tuple[float, float]]) -> FloatArray:
    """Return the outline of all straight ways within the search area and to some points, shape (k, 2)."""
    return np.array(propose_fence(plan.area_enu_m, points_enu_m, POSITION_ERROR_M))


def place_text(frame: LocalFrame, place_enu_m: Sequence[float] | FloatArray) -> str:
    """Return a place in degrees and in metres from the origin."""
    east_m, north_m = float(place_enu_m[0]), float(place_enu_m[1])
    place = frame.to_geodetic((east_m, north_m, 0.0))
    sides = f"{abs(east_m):.0f} m {'east' if east_m >= 0.0 else 'west'}"
    sides += f", {abs(north_m):.0f} m {'north' if north_m >= 0.0 else 'south'}"
    return f"{place.latitude_deg:.5f}, {place.longitude_deg:.5f} ({sides} of the origin)"
