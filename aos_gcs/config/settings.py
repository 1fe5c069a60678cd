"""Settings of a mission from its configuration."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Hashable, Mapping, Sequence
from functools import cache
from typing import Any, Final, TypeVar, cast

import pydantic
from pydantic import TypeAdapter

from aos_gcs.airspace.limits import UNLIMITED, SafetyOverrides
from aos_gcs.airspace.polygon import as_polygon
from aos_gcs.config.exact import require_exact
from aos_gcs.config.file import first_problem
from aos_gcs.config.model import LatLonDeg, MissionConfig, PreflightConfig, ServiceConfig
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.preflight.checks import OVERRIDABLE
from aos_gcs.planning.checks.check import blocking_problems
from aos_gcs.planning.detection.aperture import advise
from aos_gcs.planning.plan import plan_of
from aos_gcs.planning.proposal import altitude_layers
from aos_gcs.planning.search_settings import SearchSettings
from aos_gcs.planning.settings import (
    AutofocusSettings,
    Deadlines,
    DetectionSettings,
    FlightSettings,
    ForestSettings,
    MissionSettings,
    PreflightSettings,
    RegistrationSettings,
    RelaySettings,
    TerrainSettings,
)
from aos_gcs.planning.terrain.ground import open_model
from aos_gcs.prior.file import read_prior
from aos_gcs.prior.segments import read_segments
from aos_gcs.sharing.settings import CaltopoSettings, SharingSettings, TakSettings, WebhookSettings
from aos_gcs.swarm.registry import make_strategy
from aos_gcs.tracking.motion import MotionSettings
from aos_gcs.tracking.tracker import TrackingSettings

SettingsT = TypeVar("SettingsT")

GREATEST_AGE_S: Final = 60.0
"""Greatest age of a link or a position with which vehicles may be set to fly on, real seconds."""
GREATEST_SILENCE_S: Final = 120.0
"""Greatest silence after which a vehicle may be set to count as lost, real seconds."""
GREATEST_THRESHOLD_M2: Final = 10.0
"""Greatest visibility from which a target may be set to be in view: fifty standing persons."""
LOWEST_PLANE_M: Final = -200.0
"""Least height of the focal plane: ground that is farther below the launch site is no mission's."""


def mission_settings(config: ServiceConfig) -> MissionSettings:
    """Turn a configuration into the settings of a mission.

    Raises:
        ConfigurationError: a value is out of range or contradicts another; the text names the field.
    """
    mission = config.mission
    origin = None
    if mission.origin_deg is not None:
        latitude_deg, longitude_deg, altitude_m = mission.origin_deg
        origin = GeodeticPosition(latitude_deg, longitude_deg, AmslM(altitude_m))
    heading_rad = math.radians(mission.scan_heading_deg)
    make_strategy(config.swarm.strategy, config.swarm.parameters)  # Refused here, before anything is opened.
    area_enu_m = _area_enu_m(mission, origin)
    if not area_enu_m and (mission.auto_start or not config.api.enabled):
        raise ConfigurationError(
            "mission: give the search area either as area_deg or as area_enu_m; only a mission that waits for an "
            "operator at the dashboard can do without."
        )
    flight = _build(FlightSettings, "flight", config.flight)
    vehicle_ids = _vehicle_ids(config)
    vehicles = len(vehicle_ids) if mission.vehicles is None else mission.vehicles
    layers_m = altitude_layers(vehicles, flight.lowest_layer_m, flight.layer_spacing_m)
    settings = MissionSettings(
        vehicles=vehicles,
        vehicle_ids=vehicle_ids,
        any_vehicles=mission.any_vehicles,
        area_enu_m=area_enu_m,
        imaging=_build(ImagingSettings, "imaging", config.imaging),
        safety=_safety(config.safety, origin, layers_m),
        origin=origin,
        return_enu_m=_return_enu_m(mission, origin),
        scan_direction_enu=(math.sin(heading_rad), math.cos(heading_rad)),
        planning_fov_rad=math.radians(mission.camera_fov_deg),
        strategy=config.swarm.strategy,
        strategy_parameters=config.swarm.parameters,
        seed=mission.seed,
        flight=flight,
        search=_search(config.search),
        relay=_relay(config, vehicle_ids),
        deadlines=_build(Deadlines, "deadlines", config.deadlines),
        preflight=_preflight(config.preflight),
        detection=_build(DetectionSettings, "detection", config.detection),
        uncertainty=_uncertainty(config.uncertainty),
        tracking=_tracking(config.tracking),
        autofocus=_build(AutofocusSettings, "autofocus", config.autofocus),
        registration=_build(RegistrationSettings, "registration", config.registration),
        forest=None if config.forest is None else _build(ForestSettings, "forest", config.forest),
        terrain=None if config.terrain is None else _terrain(config.terrain),
        auto_start=mission.auto_start,
        auto_return=mission.auto_return,
    )
    _check_greatest(settings, config.clock_speed)
    _check_planes(settings)
    if settings.forest is not None:
        _check_forest(settings, settings.forest)
    _check_plan(settings)
    if settings.search.split:
        _check_split(settings)
    return settings


def sharing_settings(config: ServiceConfig) -> SharingSettings:
    """Return the systems that a configuration shares with.

    Raises:
        ConfigurationError: a value cannot be used; the text names the field.
    """
    return SharingSettings(
        tak=None if config.tak is None else _build(TakSettings, "tak", config.tak),
        webhook=None if config.webhook is None else _build(WebhookSettings, "webhook", config.webhook),
        caltopo=None if config.caltopo is None else _build(CaltopoSettings, "caltopo", config.caltopo),
    )


def _check_plan(settings: MissionSettings) -> None:
    """Refuse a mission that, as a plan, could not be flown, such as a search area outside of the geofence."""
    if settings.area_enu_m and (problems := blocking_problems(plan_of(settings), settings)):
        raise ConfigurationError(f"This mission cannot be flown ({problems[0].field}): {problems[0].text}")


def _check_split(settings: MissionSettings) -> None:
    """Refuse a split swarm where no vehicle could ever scan on."""
    fewest, looking = settings.search.fewest_to_split, settings.search.look_vehicles
    if fewest is None:
        raise ConfigurationError(
            'search.split needs search.mode = "continuous": with stops, all vehicles take part in a close look. Change '
            "the mode, or leave split out."
        )
    if settings.vehicles < fewest:
        raise ConfigurationError(
            f"search.split needs {fewest} vehicles, {looking} that look closely and {fewest - looking} that scan on, "
            f"but there are {settings.vehicles}: lower search.look_vehicles, or leave split out."
        )


def _vehicle_ids(config: ServiceConfig) -> tuple[int, ...]:
    """Return the ids of the vehicles that fly, ascending; none where an operator or a simulation decides."""
    mission = config.mission
    if mission.vehicle_ids is None:
        if mission.vehicles is None:
            raise ConfigurationError("mission: give the vehicles that fly as vehicle_ids, or their number as vehicles.")
        if (mission.auto_start or not config.api.enabled) and not mission.any_vehicles:
            raise ConfigurationError(
                "mission: a mission that starts without an operator has to name its vehicles: give vehicle_ids, or "
                "any_vehicles = true where all are simulated."
            )
        return ()
    vehicle_ids = tuple(sorted(set(mission.vehicle_ids)))
    if len(vehicle_ids) != len(mission.vehicle_ids):
        raise ConfigurationError("mission.vehicle_ids names a vehicle twice.")
    if config.link.system_id in vehicle_ids:
        raise ConfigurationError(
            f"link.system_id {config.link.system_id} is that of a vehicle in mission.vehicle_ids: give the station "
            "another one, such as 254."
        )
    if mission.vehicles not in {None, len(vehicle_ids)}:
        raise ConfigurationError(
            f"mission: vehicle_ids names {len(vehicle_ids)} vehicles, but vehicles is {mission.vehicles}; leave it out."
        )
    if mission.any_vehicles:
        raise ConfigurationError("mission: give either vehicle_ids or any_vehicles.")
    return vehicle_ids


def _relay(config: ServiceConfig, vehicle_ids: Sequence[int]) -> RelaySettings:
    """Return the settings of the relay, whose vehicles are others than those of the swarm."""
    relay = _build(RelaySettings, "relay", config.relay)
    if both := sorted(set(relay.vehicle_ids) & set(vehicle_ids)):
        raise ConfigurationError(f"relay.vehicle_ids names vehicle {both[0]}, which mission.vehicle_ids names too.")
    return relay


def _search(table: Mapping[str, Any]) -> SearchSettings:
    """Return the settings of the search; a prior or segments that cannot be used are refused here."""
    search = _build(SearchSettings, "search", table)
    if search.prior is not None:
        try:
            read_prior(search.prior)
        except (ConfigurationError, InputDataError) as error:
            raise ConfigurationError(f"search.prior: {error}") from error
    if search.segments is not None:
        try:
            read_segments(search.segments)
        except InputDataError as error:
            raise ConfigurationError(f"search.segments: {error}") from error
    return search


def _return_enu_m(mission: MissionConfig, origin: GeodeticPosition | None) -> tuple[float, float] | None:
    if mission.return_deg is None:
        return mission.return_enu_m
    if mission.return_enu_m is not None:
        raise ConfigurationError("mission: give the return point either as return_deg or as return_enu_m.")
    (point_enu_m,) = _to_enu([mission.return_deg], origin, "mission.return_deg")
    return point_enu_m


def _check_greatest(settings: MissionSettings, clock_speed: float) -> None:
    """Refuse values with which a limit would never act; ages are clock seconds."""
    limits = settings.safety.applied_to(UNLIMITED)
    faster = max(1.0, clock_speed)
    for name, value, greatest in (
        ("safety.max_link_age_s", limits.max_link_age_s, faster * GREATEST_AGE_S),
        ("safety.max_position_age_s", limits.max_position_age_s, faster * GREATEST_AGE_S),
        ("deadlines.lost_s", settings.deadlines.lost_s, faster * GREATEST_SILENCE_S),
        ("detection.threshold_m2", settings.detection.threshold_m2, GREATEST_THRESHOLD_M2),
    ):
        if value > greatest:
            raise ConfigurationError(f"{name} must be at most {greatest:g}, but is {value:g}: it would never act.")


def _check_planes(settings: MissionSettings) -> None:
    if settings.imaging.plane_height_m < LOWEST_PLANE_M:
        raise ConfigurationError(
            f"imaging.plane_height_m must be at least {LOWEST_PLANE_M:g}, but is {settings.imaging.plane_height_m:g}: "
            "a focal plane far below the ground shows nothing."
        )
    if settings.imaging.plane_height_m >= settings.flight.lowest_layer_m:
        raise ConfigurationError(
            f"imaging.plane_height_m ({settings.imaging.plane_height_m:g}) must be below flight.lowest_layer_m "
            f"({settings.flight.lowest_layer_m:g}): a focal plane above the cameras is never seen."
        )
    if settings.autofocus.enabled and settings.focus_range_m[1] >= settings.flight.lowest_layer_m:
        raise ConfigurationError(
            f"autofocus.reach_m ({settings.autofocus.reach_m:g}) above imaging.plane_height_m must be below "
            f"flight.lowest_layer_m ({settings.flight.lowest_layer_m:g}): nothing above the cameras is ever seen."
        )


def _check_forest(settings: MissionSettings, forest: ForestSettings) -> None:
    lowest_m, plane_m = settings.flight.lowest_layer_m, settings.imaging.plane_height_m
    if forest.canopy_height_m >= lowest_m - plane_m:
        raise ConfigurationError(
            f"forest.canopy_height_m ({forest.canopy_height_m:g} m above the focal plane at {plane_m:g} m) must lie "
            f"below flight.lowest_layer_m ({lowest_m:g}): correct it, or raise the lowest layer above the tree tops."
        )
    try:
        advise(settings, forest)
    except ConfigurationError as error:
        raise ConfigurationError(f"forest: {error}") from error


def _terrain(table: Mapping[str, Any]) -> TerrainSettings:
    """Return the elevation model that the file names; a model that cannot be used is refused here."""
    terrain = _build(TerrainSettings, "terrain", table)
    try:
        open_model(terrain)
    except (ConfigurationError, InputDataError) as error:
        raise ConfigurationError(f"terrain: {error}") from error
    return terrain


def _area_enu_m(mission: MissionConfig, origin: GeodeticPosition | None) -> tuple[tuple[float, float], ...]:
    if mission.area_deg is not None and mission.area_enu_m is not None:
        raise ConfigurationError("mission: give the search area either as area_deg or as area_enu_m.")
    if mission.area_deg is None and mission.area_enu_m is None:
        return ()
    if mission.area_enu_m is not None:
        area_enu_m, field = tuple(mission.area_enu_m), "mission.area_enu_m"
    else:
        area_enu_m, field = _to_enu(mission.area_deg or [], origin, "mission.area_deg"), "mission.area_deg"
    as_polygon(area_enu_m, field)  # Refused here; the search would find out in the air.
    return area_enu_m


def _safety(table: Mapping[str, Any], origin: GeodeticPosition | None, layers_m: Sequence[float]) -> SafetyOverrides:
    """Return the limits that the file sets, checked; preflight proposes the others."""
    given = dict(table)
    if "fence_deg" in given:
        if "fence_enu_m" in given:
            raise ConfigurationError("safety: give the geofence either as fence_deg or as fence_enu_m.")
        fence_deg = _validate(list[LatLonDeg], "safety.fence_deg", given.pop("fence_deg"))
        given["fence_enu_m"] = _to_enu(fence_deg, origin, "safety.fence_deg")
    if "no_go_deg" in given:
        if "no_go_enu_m" in given:
            raise ConfigurationError("safety: give the no-go zones either as no_go_deg or as no_go_enu_m.")
        zones_deg = _validate(list[list[LatLonDeg]], "safety.no_go_deg", given.pop("no_go_deg"))
        given["no_go_enu_m"] = tuple(_to_enu(zone_deg, origin, "safety.no_go_deg") for zone_deg in zones_deg)
    _refuse_unknown(SafetyOverrides, "safety", given, extra=("fence_deg", "no_go_deg"))
    overrides = _build(SafetyOverrides, "safety", given)
    limits = overrides.applied_to(UNLIMITED)
    if limits.floor_m > min(layers_m) or limits.ceiling_m < max(layers_m):
        raise ConfigurationError(
            f"safety: the altitude layers, {min(layers_m):g} to {max(layers_m):g} m, must lie between floor_m and "
            "ceiling_m; change these or flight.lowest_layer_m and flight.layer_spacing_m."
        )
    return overrides


def _preflight(config: PreflightConfig) -> PreflightSettings:
    overrides = {}
    for text in config.overrides:
        name, _, reason = (part.strip() for part in text.partition(":"))
        if name not in OVERRIDABLE:
            raise ConfigurationError(
                f"preflight.overrides: {name!r} cannot be overridden; only these can: {', '.join(sorted(OVERRIDABLE))}."
            )
        if not reason:
            raise ConfigurationError(f'preflight.overrides: {name!r} needs a reason; write "{name}: reason".')
        overrides[name] = reason
    return PreflightSettings(config.upload_fence, config.set_return_height, overrides, config.refresh_s)


def _uncertainty(table: Mapping[str, Any]) -> Uncertainty:
    """Return the uncertainties, whose angles are degrees in the file."""
    given = dict(table)
    for angle in ("attitude", "yaw"):
        if f"{angle}_rad" in given:
            raise ConfigurationError(f"uncertainty.{angle}_rad is unknown; give {angle}_deg, in degrees.")
        if f"{angle}_deg" in given:
            degrees = _validate(float, f"uncertainty.{angle}_deg", given.pop(f"{angle}_deg"))
            given[f"{angle}_rad"] = math.radians(degrees)
    return _build(Uncertainty, "uncertainty", given)


def _tracking(table: Mapping[str, Any]) -> TrackingSettings:
    given = dict(table)
    motion = _build(
        MotionSettings, "tracking.motion", _validate(dict[str, Any], "tracking.motion", given.pop("motion", {}))
    )
    return _build(TrackingSettings, "tracking", given | {"motion": motion})


def _to_enu(
    corners_deg: Sequence[tuple[float, float]], origin: GeodeticPosition | None, field: str
) -> tuple[tuple[float, float], ...]:
    if origin is None:
        raise ConfigurationError(
            f"{field} needs mission.origin_deg: latitude, longitude and altitude of the launch site."
        )
    frame = LocalFrame(origin)
    corners_enu_m = [
        frame.to_enu(GeodeticPosition(latitude_deg, longitude_deg, origin.altitude_amsl_m))
        for latitude_deg, longitude_deg in corners_deg
    ]
    return tuple((float(corner[0]), float(corner[1])) for corner in corners_enu_m)


def _refuse_unknown(settings: type[Any], section: str, table: Mapping[str, Any], extra: tuple[str, ...] = ()) -> None:
    known = [field.name for field in dataclasses.fields(settings)] + list(extra)
    for name in table:
        if name not in known:
            raise ConfigurationError(f"{section}.{name} is unknown; known are: {', '.join(known)}.")


def _build(settings: type[SettingsT], section: str, table: Mapping[str, Any]) -> SettingsT:
    """Make a settings dataclass from a table."""
    _refuse_unknown(settings, section, table)
    return _validate(settings, section, dict(table))


@cache
def _adapter(expected: type[Any]) -> TypeAdapter[Any]:
    """Return what checks values of a type: making it takes far longer than using it."""
    return TypeAdapter(expected)


def _validate(expected: type[SettingsT], place: str, value: object) -> SettingsT:
    """Return the value with its types checked by pydantic, and its ranges by the settings dataclass itself."""
    require_exact(expected, value, place)
    try:
        return cast("SettingsT", _adapter(cast("Hashable", expected)).validate_python(value))
    except pydantic.ValidationError as error:
        raise ConfigurationError(first_problem(error, place)) from error
    except ConfigurationError as error:
        raise ConfigurationError(f"{place}: {error}") from error
