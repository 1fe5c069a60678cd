"""A flight whose station ended before its vehicles had landed, as it was recorded.

The station that follows takes it up without any command: the vehicles go on as they do, in the layers that they had.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_gcs.mission.fleet.datum import LaunchGround
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import Task, VehicleSnapshot
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan, apply_plan
from aos_gcs.planning.proposal import propose_limits
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import FormerLinks

_SAME_FENCE_M = 0.5
"""Largest difference of a corner of the same geofence."""


@dataclass(frozen=True, slots=True)
class FormerFlight:
    """The flight that the station before has left."""

    last: MissionSnapshot
    """State of the mission as it was recorded last."""
    plan: MissionPlan | None
    """Plan that an operator has applied; None: it flew by the configuration."""
    recorded_utc_s: float
    """Time of that state."""

    @property
    def links(self) -> FormerLinks:
        """Proven addresses of its vehicles in flight, for the driver of the station that takes it up."""
        states = [one.telemetry for one in self.last.vehicles]
        return FormerLinks(self.recorded_utc_s, {each.vehicle_id: each.proven for each in states if each.proven})

    @property
    def vehicles(self) -> dict[int, VehicleSnapshot]:
        """Vehicles that flew in it, with layer and launch point, by id."""
        return {
            one.telemetry.vehicle_id: one
            for one in self.last.vehicles
            if one.takes_part and one.layer_height_m is not None and one.home_enu_m is not None
        }

    def settings(self, configured: MissionSettings) -> MissionSettings:
        """Return the settings that it flew by.

        Raises:
            ConfigurationError: the plan contradicts the configuration.
        """
        settings = configured if self.plan is None else apply_plan(configured, self.plan)
        vehicle_ids = tuple(sorted(self.vehicles))
        return replace(settings, vehicles=len(vehicle_ids), vehicle_ids=vehicle_ids)

    def limits(self, settings: MissionSettings) -> SafetyLimits | None:
        """Return the safety limits that it flew by; None if the settings are not those that it flew by."""
        homes_enu_m = [np.array(one.home_enu_m) for _, one in sorted(self.vehicles.items())]
        spare_enu_m = self._spare_homes_enu_m()
        # Its limits were proposed with room for vehicles of the relay; which were confirmed then is not on record.
        for standing in (frozenset(spare_enu_m) & self._spares(settings), frozenset(), frozenset(spare_enu_m)):
            limits = self._proposed(settings, [*homes_enu_m, *(spare_enu_m[key] for key in sorted(standing))])
            if limits is not None:
                return limits
        return None

    def _proposed(self, settings: MissionSettings, homes_enu_m: Sequence[NDArray[np.float64]]) -> SafetyLimits | None:
        """Return the limits that are proposed with these launch points; None if it did not fly by them."""
        try:
            limits = propose_limits(settings, homes_enu_m)
        except ConfigurationError:
            return None
        layers_m = [one.layer_height_m for one in self.vehicles.values() if one.layer_height_m is not None]
        is_same = _is_same_ring(limits.fence_enu_m, self.last.fence_enu_m)
        is_same &= tuple(settings.area_enu_m) == self.last.area_enu_m
        is_same &= limits.no_go_enu_m == self.last.no_go_enu_m
        is_same &= settings.layers_follow_ground == self.last.follows_ground
        return limits if is_same and limits.floor_m <= min(layers_m) and max(layers_m) <= limits.ceiling_m else None

    def _spare_homes_enu_m(self) -> dict[int, NDArray[np.float64]]:
        """Return where vehicles stood, shape (3,) each, that did not fly in it, by id."""
        if self.last.origin is None:
            return {}
        frame, flown = LocalFrame(self.last.origin), self.vehicles
        states = [one.telemetry for one in self.last.vehicles]
        return {
            each.vehicle_id: frame.to_enu(each.home) for each in states if each.home and each.vehicle_id not in flown
        }

    def _spares(self, settings: MissionSettings) -> frozenset[int]:
        """Return the vehicles that might have taken off for the relay; see ``Launch``."""
        is_any = settings.any_vehicles and settings.relay.enabled
        return frozenset(
            one.telemetry.vehicle_id
            for one in self.last.vehicles
            if is_any or one.is_ready or one.telemetry.vehicle_id in settings.relay.vehicle_ids
        )

    @property
    def legs(self) -> tuple[ScanLeg, ...]:
        """Legs of the scan."""
        return tuple(_leg(*leg_enu_m) for leg_enu_m in self.last.legs_enu_m)

    def flying(self, roster: Roster) -> list[Member]:
        """Return its vehicles that are heard in the air."""
        return [member for member in roster.airborne() if member.vehicle_id in self.vehicles]

    def ground(self) -> LaunchGround | None:
        """Return the ground at the launch points, above the datum that the vehicles share; None without an origin."""
        if self.last.origin is None:
            return None
        frame, altitudes_m = LocalFrame(self.last.origin), {}
        for vehicle_id, former in self.vehicles.items():
            if former.home_enu_m is not None:
                altitudes_m[vehicle_id] = frame.to_geodetic(former.home_enu_m).altitude_amsl_m
        level_m = AmslM(median(altitudes_m.values()))
        return LaunchGround(level_m, relief_m={key: each_m - level_m for key, each_m in altitudes_m.items()})

    def attach(self, roster: Roster) -> list[Member]:
        """Give its vehicles that are heard their layers and launch points again; return those now held in the air."""
        attached = []
        for member in roster.members(Task.IDLE):
            former = self.vehicles.get(member.vehicle_id)
            if former is None:
                continue
            member.choose(is_chosen=True)
            member.take_place(np.array(former.home_enu_m), former.layer_height_m)
            member.settle_altitude(former.altitude_offset_m)
            if member.airborne:
                telemetry = former.telemetry
                waypoint_enu_m = None if former.waypoint_enu_m is None else np.array(former.waypoint_enu_m)
                member.go_on(telemetry.taken_over, waypoint_enu_m, has_pilot=telemetry.has_pilot)
                roster.assign(member, Task.HELD)
                attached.append(member)
        return attached


def _is_same_ring(one: Sequence[Sequence[float]], other: Sequence[Sequence[float]]) -> bool:
    return len(one) == len(other) and bool(np.allclose(one, other, rtol=0.0, atol=_SAME_FENCE_M))


def _leg(start_enu_m: tuple[float, float], end_enu_m: tuple[float, float]) -> ScanLeg:
    way_m = np.subtract(end_enu_m, start_enu_m)
    length_m = float(np.linalg.norm(way_m))
    east, north = way_m / length_m if length_m > 0.0 else (0.0, 1.0)
    return ScanLeg(start_enu_m, (float(east), float(north)), length_m)
