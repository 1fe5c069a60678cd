"""Plans that operators make: search area, no-go zones, launch and return points, heights, strategy."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.polygon import Polygon
from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import Deadlines, FlightSettings, ForestSettings, MissionSettings
from aos_gcs.swarm.declaration import Parameter
from aos_gcs.swarm.registry import available_strategies, declared_parameters, make_strategy

SPACING_PARAMETER = "c4_m"
"""The strategies' parameter for the distance of the drones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionPlan:
    """A plan of a mission, checked by :func:`aos_gcs.planning.checks.check.check_plan` only.

    Points are horizontal ENU metres about the mission's origin, heights metres above it.
    """

    vehicles: int
    area_enu_m: Polygon
    no_go_enu_m: tuple[Polygon, ...] = ()
    launch_enu_m: tuple[float, float] | None = None
    """Launch point; vehicles that are heard report their own."""
    return_enu_m: tuple[float, float] | None = None
    """Point where the vehicles land; None: where they started."""
    fence_enu_m: Polygon | None = None
    """None: preflight proposes one around area and launch points."""
    scan_heading_rad: float = 0.0
    """Heading of the first leg, clockwise from north."""
    camera_fov_rad: float = math.radians(50.0)
    """Horizontal field of view."""
    lowest_layer_m: float = FlightSettings().lowest_layer_m
    layer_spacing_m: float = FlightSettings().layer_spacing_m
    spacing_m: float | None = None
    """c4 of the strategy; None: as in its parameters."""
    strategy: str = "aos-apso"
    strategy_parameters: Mapping[str, object] = field(default_factory=dict)
    floor_m: float | None = None
    """None: preflight proposes floor and ceiling from the layers."""
    ceiling_m: float | None = None
    fence_margin_m: float | None = None
    """Distance to keep from the geofence on the inside; None: the stopping distance."""
    cruise_speed_mps: float = FlightSettings().cruise_speed_mps
    search_mode: SearchMode = SearchSettings().mode
    search_speed_mps: float = FlightSettings().search_speed_mps
    """Speed along the legs of a continuous search."""
    rate_hz: float = ImagingSettings().rate_hz
    """Frames per second of each camera on these legs."""
    pod: float | None = None
    """Wanted probability of detection of a standing person, a mean over the search area; None: none is wanted."""
    line_spacing_m: float | None = None
    """Distance of neighbouring vehicles along the legs; None: that of the strategy."""
    leg_spacing_m: float | None = None
    """Greatest distance of neighbouring legs; None: as wide as the swarm's line sees."""
    passes: int = 1
    """Number of times that all legs are flown, to and fro."""
    split: bool = SearchSettings().split
    """Whether vehicles that are not needed for a close look scan on; in continuous searches only."""
    min_battery_fraction: float = UNLIMITED.min_battery_fraction
    """Battery fraction at which a vehicle flies home."""
    endurance_s: float = 1500.0
    """Flight time of a full battery; used for estimates only."""
    search_s: float = Deadlines().search_s
    """Time from the start after which all vehicles return, unless they watch a person."""
    forest: ForestSettings | None = None
    """None: no advice on the aperture."""

    @property
    def parameters(self) -> Mapping[str, object]:
        """The strategy's parameters, spacing included."""
        if self.spacing_m is None:
            return self.strategy_parameters
        return {**self.strategy_parameters, SPACING_PARAMETER: self.spacing_m}

    @property
    def on_legs_m(self) -> float:
        """Distance of neighbouring vehicles along the legs.

        Raises:
            ConfigurationError: the strategy cannot be made with the plan's parameters.
        """
        if self.line_spacing_m is not None:
            return self.line_spacing_m
        return make_strategy(self.strategy, self.parameters).spacing_m

    @property
    def leg_speed_mps(self) -> float:
        """Speed at which legs are flown without stops."""
        return min(self.search_speed_mps, self.cruise_speed_mps)

    @property
    def highest_layer_m(self) -> float:
        """Height of the highest altitude layer."""
        return self.lowest_layer_m + (self.vehicles - 1) * self.layer_spacing_m


@dataclass(frozen=True, slots=True)
class PlanProblem:
    """A problem of a plan, or advice on it."""

    field: str
    """Field of ``MissionPlan``; elements of a list have their index, from 0: ``no_go_enu_m[0]``."""
    text: str
    """Description of the problem, and the remedy."""
    blocking: bool = True
    """False for advice: the plan can be flown."""


@dataclass(frozen=True, slots=True)
class StrategyOptions:
    """A strategy with the parameters that a plan can set."""

    name: str
    parameters: tuple[Parameter, ...]
    """All but the spacing, which is a field of the plan."""


def available_options() -> tuple[StrategyOptions, ...]:
    """Return the strategies that a plan can name.

    A strategy that cannot be loaded has no parameters; :func:`~aos_gcs.planning.checks.check.check_plan` reports why.
    """
    return tuple(StrategyOptions(name, tuple(_parameters(name))) for name in available_strategies())


def _parameters(strategy: str) -> Iterator[Parameter]:
    try:
        parameters = declared_parameters(strategy)
    except ConfigurationError:
        return
    yield from (parameter for parameter in parameters if parameter.name != SPACING_PARAMETER)


def apply_plan(settings: MissionSettings, plan: MissionPlan) -> MissionSettings:
    """Return the settings of a mission that flies a plan; what a plan does not contain stays as it is.

    Raises:
        ConfigurationError: the plan's safety limits contradict those of the settings.
    """
    return replace(
        settings,
        vehicles=plan.vehicles,
        vehicle_ids=settings.vehicle_ids if len(settings.vehicle_ids) == plan.vehicles else (),
        area_enu_m=plan.area_enu_m,
        return_enu_m=plan.return_enu_m,
        safety=replace(
            settings.safety,
            fence_enu_m=plan.fence_enu_m,
            floor_m=plan.floor_m,
            ceiling_m=plan.ceiling_m,
            no_go_enu_m=plan.no_go_enu_m,
            margin_m=plan.fence_margin_m,
            min_battery_fraction=plan.min_battery_fraction,
        ),
        scan_direction_enu=(math.sin(plan.scan_heading_rad), math.cos(plan.scan_heading_rad)),
        planning_fov_rad=plan.camera_fov_rad,
        strategy=plan.strategy,
        strategy_parameters=plan.parameters,
        flight=replace(
            settings.flight,
            lowest_layer_m=plan.lowest_layer_m,
            layer_spacing_m=plan.layer_spacing_m,
            cruise_speed_mps=plan.cruise_speed_mps,
            search_speed_mps=plan.search_speed_mps,
        ),
        search=replace(
            settings.search,
            mode=plan.search_mode,
            pod=plan.pod,
            line_spacing_m=plan.line_spacing_m,
            leg_spacing_m=plan.leg_spacing_m,
            passes=plan.passes,
            split=plan.split,
        ),
        imaging=replace(settings.imaging, rate_hz=plan.rate_hz),
        deadlines=replace(settings.deadlines, search_s=plan.search_s),
        forest=plan.forest,
    )


def plan_of(settings: MissionSettings) -> MissionPlan:
    """Return the plan that a mission's settings amount to, as a start for an operator's own."""
    east, north = settings.scan_direction_enu
    limits = settings.safety.applied_to(UNLIMITED)
    parameters = dict(settings.strategy_parameters)
    spacing_m = parameters.pop(SPACING_PARAMETER, None)
    return MissionPlan(
        vehicles=settings.vehicles,
        area_enu_m=settings.area_enu_m,
        no_go_enu_m=limits.no_go_enu_m,
        return_enu_m=settings.return_enu_m,
        fence_enu_m=settings.safety.fence_enu_m,
        scan_heading_rad=math.atan2(east, north) % (2.0 * math.pi),
        camera_fov_rad=settings.planning_fov_rad,
        lowest_layer_m=settings.flight.lowest_layer_m,
        layer_spacing_m=settings.flight.layer_spacing_m,
        spacing_m=spacing_m if isinstance(spacing_m, int | float) else None,
        strategy=settings.strategy,
        strategy_parameters=parameters,
        floor_m=settings.safety.floor_m,
        ceiling_m=settings.safety.ceiling_m,
        fence_margin_m=settings.safety.margin_m,
        cruise_speed_mps=settings.flight.cruise_speed_mps,
        search_mode=settings.search.mode,
        search_speed_mps=settings.flight.search_speed_mps,
        rate_hz=settings.imaging.rate_hz,
        pod=settings.search.pod,
        line_spacing_m=settings.search.line_spacing_m,
        leg_spacing_m=settings.search.leg_spacing_m,
        passes=settings.search.passes,
        split=settings.search.split,
        min_battery_fraction=limits.min_battery_fraction,
        search_s=settings.deadlines.search_s,
        forest=settings.forest,
    )
