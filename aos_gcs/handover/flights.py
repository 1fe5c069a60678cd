"""Flights of each vehicle, from the states that a mission has recorded once per second."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Final

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.handover.model import LoggedFlight
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import VehicleSnapshot
from aos_gcs.ports import LandedState

COLUMNS: Final = (
    *("operation", "sortie", "vehicle", "takeoff_utc", "landing_utc", "duration_s", "distance_m", "max_height_m"),
    *("battery_takeoff_percent", "battery_landing_percent", "battery_used_percent"),
)
"""Columns of the flight log."""
_AIRBORNE: Final = (LandedState.TAKING_OFF, LandedState.IN_AIR, LandedState.LANDING)
_OFF_GROUND_M: Final = 1.0
"""Height above home from which an armed vehicle flies that reports no landed state."""
_SHORTEST_M: Final = 0.5
"""Distance from the previous position of a way from which a position is part of it: a drawing needs no more."""


@dataclass(slots=True)
class _OpenFlight:
    """A flight as far as it was read."""

    takeoff_utc_s: float
    battery_takeoff: float | None
    last_utc_s: float
    battery_last: float | None
    last_enu_m: EnuPoint | None = None
    distance_m: float = 0.0
    max_height_m: float = 0.0
    way_enu_m: list[EnuPoint] = field(default_factory=list)

    def go_on(self, utc_s: float, vehicle: VehicleSnapshot) -> None:
        """Take in the next state."""
        self.last_utc_s = utc_s
        battery = vehicle.telemetry.battery_fraction
        self.battery_takeoff = battery if self.battery_takeoff is None else self.battery_takeoff
        self.battery_last = self.battery_last if battery is None else battery
        here = vehicle.position_enu_m
        if here is None or not all(map(math.isfinite, here)):
            return
        if self.last_enu_m is not None:
            self.distance_m += math.dist(self.last_enu_m, here)
        self.last_enu_m = here
        self.max_height_m = max(self.max_height_m, here[2])
        if not self.way_enu_m or math.dist(self.way_enu_m[-1], here) >= _SHORTEST_M:
            self.way_enu_m.append(here)

    def closed(self, vehicle_id: int, landing_utc_s: float | None) -> LoggedFlight:
        """Return the flight."""
        end_utc_s = self.last_utc_s if landing_utc_s is None else landing_utc_s
        return LoggedFlight(
            vehicle_id=vehicle_id,
            takeoff_utc_s=self.takeoff_utc_s,
            landing_utc_s=landing_utc_s,
            duration_s=end_utc_s - self.takeoff_utc_s,
            distance_m=self.distance_m,
            max_height_m=self.max_height_m,
            battery_takeoff=self.battery_takeoff,
            battery_landing=self.battery_last,
        )


class FlightLog:
    """Collects the flights of a mission from its states, which are given in the order of time."""

    def __init__(self) -> None:
        self._open: dict[int, _OpenFlight] = {}
        self._flights: list[tuple[LoggedFlight, tuple[EnuPoint, ...]]] = []

    def add(self, utc_s: float, snapshot: MissionSnapshot) -> None:
        """Take in a state of the mission."""
        for vehicle in snapshot.vehicles:
            vehicle_id = vehicle.telemetry.vehicle_id
            flight = self._open.get(vehicle_id)
            if is_airborne(vehicle):
                if flight is None:
                    battery = vehicle.telemetry.battery_fraction
                    flight = self._open[vehicle_id] = _OpenFlight(utc_s, battery, utc_s, battery)
                flight.go_on(utc_s, vehicle)
            elif flight is not None:
                flight.go_on(utc_s, vehicle)
                self._close(vehicle_id, self._open.pop(vehicle_id), utc_s)

    def finish(self) -> tuple[tuple[LoggedFlight, tuple[EnuPoint, ...]], ...]:
        """Return all flights with their ways, by vehicle and time; those that no landing ends are open."""
        for vehicle_id, flight in self._open.items():
            self._close(vehicle_id, flight, None)
        self._open = {}
        return tuple(sorted(self._flights, key=lambda one: (one[0].vehicle_id, one[0].takeoff_utc_s)))

    def _close(self, vehicle_id: int, flight: _OpenFlight, landing_utc_s: float | None) -> None:
        self._flights.append((flight.closed(vehicle_id, landing_utc_s), tuple(flight.way_enu_m)))


def is_airborne(vehicle: VehicleSnapshot) -> bool:
    """Return whether a vehicle flies, by its landed state, or by its height where it reports none."""
    telemetry = vehicle.telemetry
    if telemetry.landed is not LandedState.UNKNOWN:
        return telemetry.armed and telemetry.landed in _AIRBORNE
    height_m = telemetry.height_above_home_m
    return telemetry.armed and height_m is not None and height_m > _OFF_GROUND_M


def to_csv(flights: Sequence[LoggedFlight], operation: str, sortie: int) -> str:
    """Return the flight log, one line per flight; times are UTC as of ISO 8601, unknown values are empty."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for flight in flights:
        landing = "" if flight.landing_utc_s is None else _iso(flight.landing_utc_s)
        figures = (round(flight.duration_s), round(flight.distance_m), f"{flight.max_height_m:.1f}")
        charges = map(_percent, (flight.battery_takeoff, flight.battery_landing, flight.battery_used))
        writer.writerow((operation, sortie, flight.vehicle_id, _iso(flight.takeoff_utc_s), landing, *figures, *charges))
    return text.getvalue()


def _iso(utc_s: float) -> str:
    return datetime.fromtimestamp(utc_s, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def _percent(fraction: float | None) -> str:
    return "" if fraction is None or not math.isfinite(fraction) else f"{100.0 * fraction:.0f}"
