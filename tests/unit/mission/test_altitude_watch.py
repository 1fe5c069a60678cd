"""Distance that others keep from a vehicle whose height drifts."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.fleet.watches.altitude import AltitudeWatch
from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Clock, FlightMode, LandedState, VehicleState

STEP_S, GROUND_M, LAYER_M = 0.2, 260.0, 20.0
SEPARATION_M, SPACING_M = 1.5, 2.5


def state(height_m: float, *, flies: bool) -> VehicleState:
    """Return what a vehicle reports whose receiver is exact."""
    return VehicleState(
        vehicle_id=1,
        mode=FlightMode.GUIDED,
        armed=flies,
        landed=LandedState.IN_AIR if flies else LandedState.ON_GROUND,
        velocity_enu_mps=(0.0, 0.0, 0.0),
        gps_fix=6,
        horizontal_accuracy_m=0.015,
        vertical_accuracy_m=0.03,
        height_above_home_m=AboveHomeM(height_m),
        gps_altitude_amsl_m=GROUND_M + height_m,
        position_at_s=0.0,
    )


class Swarm:
    """Two vehicles that believe to be in their layers; stands in for the roster."""

    def __init__(self) -> None:
        self.all = [
            cast(
                "Any",
                SimpleNamespace(
                    vehicle_id=vehicle_id,
                    state=replace(state(0.0, flies=False), vehicle_id=vehicle_id),
                    home_enu_m=np.zeros(3),
                    last_command=None,
                    altitude_doubt_m=0.0,
                ),
            )
            for vehicle_id in (1, 2)
        ]
        self.flies = False

    def members(self) -> list[Any]:
        return self.all

    def airborne(self) -> list[Any]:
        return self.all if self.flies else []

    def is_fresh(self, _at_s: float) -> bool:
        return True

    def position_age_s(self, _member: Any) -> float:
        return 0.0

    def position_enu_m(self, _member: Any) -> np.ndarray:
        return np.array([0.0, 0.0, LAYER_M])


@pytest.mark.parametrize("climb_mps", [-0.19, 0.1])
def test_the_doubt_covers_a_drift_though_averages_lag_behind_it(climb_mps: float) -> None:
    swarm, time = Swarm(), SimpleNamespace(s=0.0)
    clock = cast("Clock", SimpleNamespace(now_s=lambda: time.s))
    journal = cast("Journal", SimpleNamespace(notice=lambda *_: None))
    watch = AltitudeWatch(cast("Roster", swarm), clock, journal)
    watch.look(SEPARATION_M, SPACING_M)
    swarm.flies = True
    away_m, leaves_at_m = 0.0, None
    for step in range(120):
        time.s += STEP_S
        away_m += climb_mps * STEP_S if step > 60 else 0.0
        for member in swarm.all:
            true_m = LAYER_M - (away_m if member.vehicle_id == 1 else 0.0)
            member.state = replace(state(true_m, flies=True), vehicle_id=member.vehicle_id)
        if watch.look(SEPARATION_M, SPACING_M):
            leaves_at_m = abs(away_m) if leaves_at_m is None else leaves_at_m
            assert swarm.all[0].altitude_doubt_m >= abs(away_m)
    assert leaves_at_m is not None
    assert leaves_at_m < SPACING_M - 0.5
    assert swarm.all[1].altitude_doubt_m == 0.0


def test_a_landing_that_is_reported_in_flight_is_no_launch_point() -> None:
    swarm, time = Swarm(), SimpleNamespace(s=0.0)
    clock = cast("Clock", SimpleNamespace(now_s=lambda: time.s))
    watch = AltitudeWatch(cast("Roster", swarm), clock, cast("Journal", SimpleNamespace(notice=lambda *_: None)))
    watch.look(SEPARATION_M, SPACING_M)
    swarm.flies = True
    for step in range(120):
        time.s += STEP_S
        for member in swarm.all:
            member.state = replace(state(LAYER_M, flies=True), vehicle_id=member.vehicle_id)
        if 50 < step < 55:
            swarm.all[0].state = replace(swarm.all[0].state, landed=LandedState.ON_GROUND)
        assert not watch.look(SEPARATION_M, SPACING_M)
