"""Preflight checks against the ground: what the flight passes over, and the altitudes that vehicles report on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface
from aos_gcs.airspace.terrain import GroundRaster
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.fleet.datum import home_altitude_m, is_grounded
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.plan import plan_of
from aos_gcs.planning.settings import MissionSettings, TerrainSettings
from aos_gcs.planning.terrain.check import MAX_ALTITUDE_ERROR_M, flown_conflicts, surface_warning
from aos_gcs.planning.terrain.following import highest_return
from aos_gcs.planning.terrain.ground import floor_above_ground_m, ground_limits, ground_of_limits
from aos_gcs.planning.terrain.layer_surface import layer_surface
from aos_gcs.planning.terrain.returns import ReturnClearance, return_clearance

_CHANGE = "change the plan, or move the launch points"


@dataclass(frozen=True, slots=True, eq=False)
class SurveyedTerrain:
    """Ground below a flight, as its vehicles see it that stand on it."""

    limits: SafetyLimits
    """Limits of the flight, with those above the ground where that is known."""
    ground: GroundRaster | None
    """None if the model cannot be used; the check says why."""
    checks: tuple[PreflightCheck, ...]
    """Checks of the mission."""
    surface: ReferenceSurface | None = LEVEL
    """Surface that the altitude layers are offset from; None where it would follow ground that is not known."""
    clearance: ReturnClearance | None = None
    """What autopilots' own returns have to clear; None while no ground is known."""


def survey_terrain(
    settings: MissionSettings,
    terrain: TerrainSettings,
    origin: GeodeticPosition,
    limits: SafetyLimits,
    homes_enu_m: Mapping[int, NDArray[np.float64]],
    *,
    scans: bool = True,
) -> SurveyedTerrain:
    """Read the ground within the geofence, and compare the flight with it; it takes seconds for large models.

    Args:
        settings: settings of the mission.
        terrain: those of its elevation model.
        origin: origin of the local frame.
        limits: limits of the flight so far.
        homes_enu_m: launch points by vehicle, shape (3,) each.
        scans: whether the swarm's line is flown on legs over the search area; else vehicles fly anywhere within it.
    """
    homes_m = np.array(list(homes_enu_m.values()))
    floor_m = floor_above_ground_m(terrain, settings.forest, limits.floor_m)
    try:
        limited = replace(limits, above_ground=ground_limits(terrain, origin, homes_m, floor_m))
        ground = ground_of_limits(terrain, origin, limited)
    except (ConfigurationError, InputDataError) as error:
        failure = checks.failed(checks.MISSION, checks.TERRAIN, str(error), "correct the elevation model")
        return SurveyedTerrain(limits, None, (failure,), None if terrain.follow else LEVEL)
    if ground is None:
        raise RuntimeError("limits above the ground without ground")
    middle_m = homes_m[:, :2].mean(axis=0)
    plan = replace(plan_of(settings), launch_enu_m=(float(middle_m[0]), float(middle_m[1])), floor_m=limits.floor_m)
    legs = planned_legs(plan, settings.imaging.plane_height_m) if scans else ()
    standing = [(float(home_m[0]), float(home_m[1])) for home_m in homes_m]
    frame, surface = LocalFrame(origin), layer_surface(terrain, ground, limited, plan.cruise_speed_mps)
    conflicts = flown_conflicts(plan, terrain, frame, ground, homes_enu_m=standing, legs=legs, surface=surface)
    found = [checks.failed(checks.MISSION, checks.TERRAIN, each.text, _CHANGE) for each in conflicts]
    if (warning := surface_warning(terrain)) is not None:
        found.append(checks.warned(checks.MISSION, checks.TERRAIN, warning, "use a terrain model where there is one"))
    if not surface.is_level:
        found += _check_returns(highest_return(plan, standing, ground, surface, frame), terrain.ceiling_above_ground_m)
    clearance = return_clearance(plan, legs, list(homes_m), ground=ground, frame=frame, floor_m=floor_m)
    return SurveyedTerrain(_moved(limited, settings, surface), ground, tuple(found), surface, clearance)


def _moved(limits: SafetyLimits, settings: MissionSettings, surface: ReferenceSurface) -> SafetyLimits:
    """Return limits whose floor and ceiling follow the surface of the layers, unless they were set."""
    floor_m, ceiling_m = limits.floor_m, limits.ceiling_m
    if settings.safety.floor_m is None:
        floor_m += surface.lowest_m
    if settings.safety.ceiling_m is None:
        ceiling_m += surface.highest_m
    return replace(limits, floor_m=floor_m, ceiling_m=ceiling_m)


def _check_returns(highest: tuple[float, str] | None, ceiling_m: float) -> list[PreflightCheck]:
    """Warn of autopilots that return by themselves, above the highest place of the surface, beyond the ceiling."""
    if highest is None or highest[0] <= ceiling_m:
        return []
    text = (
        f"autopilots that return by themselves are up to {highest[0]:.1f} m above the ground at {highest[1]}, "
        f"{highest[0] - ceiling_m:.1f} m beyond the ceiling above ground"
    )
    return [checks.warned(checks.MISSION, checks.TERRAIN, text, "lower the layers, or fly where there is less relief")]


def check_take_off_altitudes(
    members: Sequence[Member], frame: LocalFrame | None, ground: GroundRaster | None
) -> list[PreflightCheck]:
    """Return for every vehicle whether the altitude that it reports on the ground agrees with the elevation model."""
    if frame is None or ground is None:
        return []
    return [_check_altitude(member, frame, ground) for member in members]


def _check_altitude(member: Member, frame: LocalFrame, ground: GroundRaster) -> PreflightCheck:
    state, vehicle_id = member.state, member.vehicle_id
    altitude_amsl_m = state.gps_altitude_amsl_m if is_grounded(state) else None
    if altitude_amsl_m is None:
        altitude_amsl_m = home_altitude_m(state)
    if state.home is None or altitude_amsl_m is None:
        return checks.failed(vehicle_id, checks.TERRAIN, "altitude unknown", "wait for the position estimate")
    # A vehicle that has landed elsewhere moves its home to where it stands when it is armed.
    place = state.position if is_grounded(state) and state.position is not None else state.home
    place_enu_m = frame.to_enu(replace(place, altitude_amsl_m=altitude_amsl_m))
    above_m = float(place_enu_m[2]) - ground.model_height_m(place_enu_m[:2])
    if not np.isfinite(above_m):
        text = "the ground is not known at its launch point"
        return checks.failed(vehicle_id, checks.TERRAIN, text, "move it, or add a file that covers it")
    side = "above" if above_m >= 0.0 else "below"
    text = f"GPS altitude {altitude_amsl_m:.1f} m, {abs(above_m):.1f} m {side} the ground of the elevation model"
    if abs(above_m) > MAX_ALTITUDE_ERROR_M:
        remedy = f"{MAX_ALTITUDE_ERROR_M:g} m are allowed: wait for a better fix, or check the model's vertical datum"
        return checks.failed(vehicle_id, checks.TERRAIN, text, remedy)
    return checks.passed(vehicle_id, checks.TERRAIN, text)
