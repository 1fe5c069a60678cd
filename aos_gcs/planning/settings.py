"""Settings of a mission."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Final

from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.elevation.datum import VerticalDatum
from aos_gcs.elevation.model import ModelKind
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.model import SurfaceKind
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.search_settings import MIN_SWARM, SearchSettings
from aos_gcs.tracking.tracker import TrackingSettings


class _Positive:
    """Settings all of whose numbers must be finite and above 0."""

    __slots__ = ()

    def __post_init__(self) -> None:
        for entry in fields(self):  # type: ignore[arg-type]
            value = getattr(self, entry.name)
            if not isinstance(value, bool) and not (math.isfinite(value) and value > 0):
                raise ConfigurationError(f"{entry.name} must be a finite number above 0, but is {value}.")


MAX_HEIGHT_M: Final = 1000.0
"""Greatest height of a layer, a floor or a ceiling above the origin."""
GREATEST_FLIGHT_SETTINGS: Final[Mapping[str, float]] = MappingProxyType(
    {"lowest_layer_m": MAX_HEIGHT_M, "layer_spacing_m": 100.0, "cruise_speed_mps": 50.0, "search_speed_mps": 50.0}
)
"""Greatest values of settings of a flight: more is a slip of the pen."""
SLOWEST_MPS: Final = 0.1
"""Least speed of a flight: less is a slip of the pen."""
LEAST_FLIGHT_SETTINGS: Final[Mapping[str, float]] = MappingProxyType(
    {"lowest_layer_m": 5.0, "cruise_speed_mps": SLOWEST_MPS, "search_speed_mps": SLOWEST_MPS}
)
"""Least values of settings of a flight; the floor lies 5 m below the lowest layer unless it is set."""


@dataclass(frozen=True, slots=True)
class FlightSettings(_Positive):
    """Layers, speed and arrival. Heights are above the mission's origin."""

    lowest_layer_m: float = 35.0
    """Height of the lowest altitude layer; h in the papers."""
    layer_spacing_m: float = 2.5
    """Vertical distance of two vehicles' layers. The papers simulate 1 m; vehicles without RTK need 3 m and more."""
    cruise_speed_mps: float = 10.0
    search_speed_mps: float = 5.0
    """Speed along the legs of a continuous search, at most the cruise speed."""
    arrival_radius_m: float = 0.5
    """Distance to the waypoint at which a vehicle has arrived, if it is slow enough."""
    arrival_speed_mps: float = 0.5
    """Speed below which a vehicle has arrived, so that frames are not blurred and poses not late."""
    reverse_heading: bool = True
    """Whether vehicles turn round from step to step while a target may be in view: the constant tilt of a camera then
    displaces it to opposite sides, which tells the tilt."""

    def __post_init__(self) -> None:
        _Positive.__post_init__(self)
        for name, greatest in GREATEST_FLIGHT_SETTINGS.items():
            if getattr(self, name) > greatest:
                raise ConfigurationError(f"{name} must be at most {greatest:g}, but is {getattr(self, name):g}.")
        for name, least in LEAST_FLIGHT_SETTINGS.items():
            if getattr(self, name) < least:
                raise ConfigurationError(f"{name} must be at least {least:g}, but is {getattr(self, name):g}.")

    @property
    def leg_speed_mps(self) -> float:
        """Speed at which legs are flown without stops."""
        return min(self.search_speed_mps, self.cruise_speed_mps)


MAX_SPARES: Final = 50
"""Greatest number of vehicles that wait to take the places of others."""


@dataclass(frozen=True, slots=True)
class RelaySettings:
    """Settings of the relay: vehicles on the ground take the places of those whose batteries run low."""

    enabled: bool = False
    vehicle_ids: tuple[int, ...] = ()
    """Vehicles beside those of the swarm that may take off for it, once each; naming them is the permission."""
    swap_s: float = 180.0
    """Time on the ground for another battery, with which replacements are planned."""
    wind_mps: float = 0.0
    """Headwind against which the way home is reckoned."""

    def __post_init__(self) -> None:
        for name, greatest in (("swap_s", 7200.0), ("wind_mps", 50.0)):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0.0 <= value <= greatest):
                raise ConfigurationError(f"{name} must be 0 or more and at most {greatest:g}, but is {value}.")
        if len(self.vehicle_ids) > MAX_SPARES:
            raise ConfigurationError(f"vehicle_ids may name {MAX_SPARES} vehicles, but names {len(self.vehicle_ids)}.")
        if any(not 1 <= one <= 250 for one in self.vehicle_ids):
            raise ConfigurationError(f"vehicle_ids must lie within 1 and 250, but are {list(self.vehicle_ids)}.")
        if self.vehicle_ids and not self.enabled:
            raise ConfigurationError("vehicle_ids names vehicles for a relay; set enabled = true, or leave them out.")


@dataclass(frozen=True, slots=True)
class Deadlines(_Positive):
    """Clock seconds after which the mission goes on without a vehicle, or gives up."""

    connect_s: float = 60.0
    preflight_s: float = 120.0
    command_s: float = 10.0
    takeoff_s: float = 90.0
    move_s: float = 30.0
    """Flight to a waypoint of one step."""
    transfer_s: float = 180.0
    """Flight to the line, or home."""
    capture_s: float = 20.0
    search_s: float = 1200.0
    """Time from the start after which all vehicles return, unless they watch a person; batteries last as long."""
    land_s: float = 240.0
    lost_s: float = 5.0
    """Silence after which a vehicle counts as lost."""
    all_lost_s: float = 15.0
    """Silence of all vehicles after which the mission ends."""


@dataclass(frozen=True, slots=True)
class DetectionSettings(_Positive):
    """Conditions under which a target is in view, found and lost."""

    threshold_m2: float = 0.05
    """T: visibility from which the target is in view. A standing person shows 0.1 to 0.2 m² to one camera without
    trees; a forest without a person marks next to nothing."""
    found_steps: int = 6
    """Sightings of a target, in one place, before it is announced, if together they say it is a person; as many looks
    have to tell it. A look rests on the frames of three steps: six are two that share no frame, and those between."""
    found_radius_m: float = 1.0
    """Greatest distance of those sightings from their mean."""
    found_min_count: int = 2
    """Frames that must agree on one cell of the blob, where no temperatures tell what it is."""
    look_steps: int = 12
    """Steps of converging on one target after which it is decided what it is, and left."""
    lost_steps: int = 3
    """Consecutive steps out of view before a found target counts as lost."""
    reacquire_steps: int = 8
    """Steps towards where the target was last seen before the scan goes on where it was left."""
    hold_steps: int = 3
    """Steps in FOUND before the search goes on, or an unattended mission returns."""
    stop_at_first: bool = False
    """Whether the search ends at the first possible person instead of the end of the search area."""


@dataclass(frozen=True, slots=True)
class PreflightSettings:
    """Settings of preflight: what it may change, and which failed checks it overrides."""

    upload_fence: bool = False
    """Write the mission's geofence to the vehicles, with the parameters that enforce it."""
    set_return_height: bool = False
    """Set the failsafe return height of each vehicle to its altitude layer, and restore it after landing."""
    overrides: Mapping[str, str] = field(default_factory=dict)
    """Reason by check whose failures do not block the launch, on any vehicle."""
    refresh_s: float = 60.0
    """Pause before a vehicle whose settings were good is asked for them again."""


@dataclass(frozen=True, slots=True)
class AutofocusSettings(_Positive):
    """Search for the height of the focal plane during a mission."""

    enabled: bool = False
    reach_m: float = 4.0
    """Range below and above ``imaging.plane_height_m``. Leave crowns out: they have most texture."""
    interval_steps: int = 3

    def is_due(self, step: int) -> bool:
        """Whether autofocus runs after this step."""
        return self.enabled and step % self.interval_steps == 0


@dataclass(frozen=True, slots=True)
class RegistrationSettings(_Positive):
    """Estimation of the errors of poses from the frames."""

    enabled: bool = False
    min_confidence: float = 0.6
    """Confidence from which poses are corrected, 0 to 1."""
    interval_steps: int = 1

    def __post_init__(self) -> None:
        _Positive.__post_init__(self)
        if self.min_confidence > 1.0:
            raise ConfigurationError(f"min_confidence must be at most 1, but is {self.min_confidence}.")

    def is_due(self, step: int) -> bool:
        """Whether registration runs after this step."""
        return self.enabled and step % self.interval_steps == 0


@dataclass(frozen=True, slots=True)
class ForestSettings(_Positive):
    """Canopy above the ground, for advice on the aperture; heights are above the focal plane."""

    canopy_height_m: float
    crown_base_m: float
    occluder_size_m: float = 1.4
    """Diameter of twigs with their leaves; docs/research/imaging.md says why."""
    occlusion: float = 0.85
    """Share of the ground that one image does not see, below 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TerrainSettings:
    """Elevation model of the ground, and the heights above it that are kept."""

    files: tuple[str, ...]
    """GeoTIFF or ASC files of one coordinate system and grid."""
    kind: ModelKind
    """Whether the heights are those of the ground, or of whatever was seen from above."""
    datum: VerticalDatum | None = None
    """Vertical datum of files that state none."""
    crs: str | None = None
    """Coordinate system of files that state none, such as ``EPSG:31255``."""
    geoid: str | None = None
    """PROJ's grid of the geoid, for ellipsoidal heights; None: looked for in PROJ's folders."""
    floor_above_ground_m: float | None = None
    """Smallest height above the ground; None: that of the floor above the origin, or 5 m above the canopy of a known
    forest where that is less."""
    ceiling_above_ground_m: float = 120.0
    """Greatest height above the ground."""
    follow: bool = False
    """Whether the altitude layers follow the ground; else they are level."""

    def __post_init__(self) -> None:
        if not self.files:
            raise ConfigurationError("files must name at least one file.")
        floor_m, ceiling_m = self.floor_above_ground_m, self.ceiling_above_ground_m
        for name, value in (("floor_above_ground_m", floor_m), ("ceiling_above_ground_m", ceiling_m)):
            if value is not None and not (math.isfinite(value) and 0.0 < value <= MAX_HEIGHT_M):
                raise ConfigurationError(f"{name} must be above 0 and at most {MAX_HEIGHT_M:g}, but is {value:g}.")
        if floor_m is not None and floor_m >= ceiling_m:
            raise ConfigurationError(
                f"floor_above_ground_m ({floor_m:g}) must be below ceiling_above_ground_m ({ceiling_m:g})."
            )


@dataclass(frozen=True, slots=True)
class MissionSettings:
    """A whole mission."""

    vehicles: int
    """Number of vehicles that fly."""
    area_enu_m: tuple[tuple[float, float], ...]
    """Search area, a simple polygon."""
    imaging: ImagingSettings
    safety: SafetyOverrides = field(default_factory=SafetyOverrides)
    """Safety limits that differ from those proposed around the search area, the launch points and the layers."""
    vehicle_ids: tuple[int, ...] = ()
    """System ids of the vehicles that fly, ascending; others are never armed. Empty: not decided yet."""
    any_vehicles: bool = False
    """Fly with the lowest ids heard where ``vehicle_ids`` is empty, for simulations; else an operator chooses."""
    origin: GeodeticPosition | None = None
    """None: the home of the vehicle with the lowest id."""
    return_enu_m: tuple[float, float] | None = None
    """Point around which all vehicles land; None: each where it started."""
    scan_direction_enu: tuple[float, float] = (0.0, 1.0)
    planning_fov_rad: float = math.radians(50.0)
    """Horizontal field of view that legs are planned for; images carry their own camera model."""
    strategy: str = "aos-apso"
    strategy_parameters: Mapping[str, object] = field(default_factory=dict)
    seed: int = 0
    flight: FlightSettings = field(default_factory=FlightSettings)
    search: SearchSettings = field(default_factory=SearchSettings)
    relay: RelaySettings = field(default_factory=RelaySettings)
    deadlines: Deadlines = field(default_factory=Deadlines)
    preflight: PreflightSettings = field(default_factory=PreflightSettings)
    detection: DetectionSettings = field(default_factory=DetectionSettings)
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    tracking: TrackingSettings = field(default_factory=TrackingSettings)
    autofocus: AutofocusSettings = field(default_factory=AutofocusSettings)
    registration: RegistrationSettings = field(default_factory=RegistrationSettings)
    forest: ForestSettings | None = None
    """None: no advice on the aperture."""
    terrain: TerrainSettings | None = None
    """None: the ground counts as level."""
    auto_start: bool = False
    """Start as soon as preflight has passed, without an operator."""
    auto_return: bool = False
    """Return after ``hold_steps`` in FOUND, without an operator, where the search stops at the first person."""

    @property
    def fewest_vehicles(self) -> int:
        """Number of vehicles below which the search does not go on."""
        return min(MIN_SWARM, self.vehicles)

    @property
    def focus_follows_ground(self) -> bool:
        """Whether the focal plane follows the elevation model: one of what was seen from above shows no ground."""
        is_of_ground = self.terrain is not None and self.terrain.kind is ModelKind.TERRAIN
        return is_of_ground and self.imaging.surface is SurfaceKind.TERRAIN

    @property
    def layers_follow_ground(self) -> bool:
        """Whether the altitude layers follow the ground of the elevation model."""
        return self.terrain is not None and self.terrain.follow

    @property
    def focus_range_m(self) -> tuple[float, float]:
        """Lowest and greatest height, above the surface that the focal plane follows, that autofocus may choose."""
        reach_m = self.autofocus.reach_m
        return self.imaging.plane_height_m - reach_m, self.imaging.plane_height_m + reach_m
