"""Simulated vehicles over ground that is not level: contact, landing, heights and sensors, in virtual time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import LocalFrame
from aos_sim.errors.model import error_model
from aos_sim.swarm import DEFAULT_ORIGIN, SimulatedSwarm, SwarmOptions, home_positions_enu_m
from aos_sim.vehicle.targets import Surroundings
from aos_sim.world.relief import Relief
from aos_sim.world.terrain import make_relief
from tests.fakes.air_flight import WarmSpot

BOX = (-50.0, -20.0, 50.0, 108.0)
TILTED = Relief(np.outer([-5.0, 45.0], np.ones(2)) + np.array([-2.0, 2.0]), west_m=-50.0, south_m=-25.0, cell_m=250.0)
"""Rises by 20 per cent to the north and by 1.6 to the east, over the launch site, too."""


def ground(terrain: str) -> Relief:
    relief = make_relief(terrain, 3, BOX, level_north_m=8.0, origin=None)
    assert relief is not None
    return relief


class Air:
    """A swarm without sockets, flown by its flight controllers."""

    def __init__(self, flavour: str, relief: Relief | None, grade: str = "none", vehicles: int = 3) -> None:
        options = SwarmOptions(
            vehicles=vehicles,
            step_ticks=5,
            cameras=False,
            autopilot=flavour,
            errors=error_model(grade),
            start_up_s=0.0,
            # Nobody sends heartbeats here, for whose absence PX4 would return home.
            parameters={"NAV_DLL_ACT": 0.0} if flavour == "px4" else {},
        )
        self.relief = relief
        self.swarm = SimulatedSwarm(options, WarmSpot(), relief)

    def advance(self, seconds: float) -> None:
        for _ in range(round(seconds * 10)):
            self.swarm._tick()

    def advance_until_landed(self, limit_s: float) -> None:
        """Let time pass until all stand on the ground."""
        for _ in range(round(limit_s)):
            if self.swarm.report().landed == len(self.swarm.vehicles):
                return
            self.advance(1.0)

    def take_off(self, height_m: float) -> None:
        for index, vehicle in enumerate(self.swarm.vehicles):
            kinematics, flight = self.swarm.kinematics(index + 1), vehicle.autopilot.flight
            flight.arm(kinematics, self.swarm.now.s)
            flight.take_off(height_m + 2 * index, kinematics, self.swarm.now.s)
        self.advance(height_m / 2)
        homes_up_m = [home_enu_m[2] for home_enu_m in self.swarm.homes_enu_m.values()]
        assert (self.swarm.state.position_enu_m[:, 2] - homes_up_m).min() > height_m - 1.0

    def above_ground_m(self) -> np.ndarray:
        assert self.relief is not None
        east, north, up = self.swarm.state.position_enu_m.T
        return up - self.relief.height_m(east, north)


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
@pytest.mark.parametrize("terrain", ["hills", "slope:20"])
def test_a_flight_over_relief_lands_on_the_hillside_and_at_home(flavour: str, terrain: str) -> None:
    air = Air(flavour, ground(terrain), "rtk")
    air.take_off(60.0)
    for index, vehicle in enumerate(air.swarm.vehicles):
        place_enu_m = (20.0 * index - 20.0, 90.0, 60.0 + 2 * index)
        vehicle.autopilot.flight.fly_to(place_enu_m, air.swarm.kinematics(index + 1), air.swarm.now.s)
    air.advance(25.0)
    reached = air.swarm.report()
    assert reached.min_height_above_ground_m == pytest.approx(air.above_ground_m().min(), abs=0.5)
    first, second, third = (vehicle.autopilot.flight for vehicle in air.swarm.vehicles)
    for number, flight in enumerate((first, second), start=1):
        flight.land(air.swarm.kinematics(number), air.swarm.now.s)
    third.return_home(air.swarm.kinematics(3), air.swarm.now.s)
    air.advance_until_landed(150.0)
    report = air.swarm.report()
    assert report.landed == 3
    np.testing.assert_allclose(air.above_ground_m(), 0.0, atol=1e-9)
    assert abs(air.swarm.state.position_enu_m[0, 2]) > 2.0
    assert math.dist(air.swarm.state.position_enu_m[2], air.swarm.homes_enu_m[3]) < 0.5


def test_vehicles_stand_on_the_ground_at_their_launch_points_and_stay() -> None:
    air = Air("arducopter", TILTED, vehicles=12)
    homes_enu_m = home_positions_enu_m(12, TILTED)
    assert np.ptp(homes_enu_m[:, 2]) > 1.0
    np.testing.assert_array_equal(air.swarm.state.position_enu_m, homes_enu_m)
    air.advance(2.0)
    np.testing.assert_array_equal(air.swarm.state.position_enu_m, homes_enu_m)
    assert air.swarm.state.on_ground.all()
    assert air.swarm.report().min_height_above_ground_m is None
    assert home_positions_enu_m(12)[:, 2].tolist() == [0.0] * 12


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
def test_heights_count_from_home_altitudes_from_the_sea_and_ranges_from_the_ground(flavour: str) -> None:
    air = Air(flavour, TILTED)
    air.take_off(30.0)
    autopilot, home_enu_m = air.swarm.vehicles[0].autopilot, air.swarm.homes_enu_m[1]
    autopilot.flight.fly_to((0.0, 60.0, home_enu_m[2] + 30.0), air.swarm.kinematics(1), air.swarm.now.s)
    air.advance(20.0)
    ground_m = float(TILTED.height_m(0.0, 60.0))
    position = autopilot._build(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT)
    assert position.relative_alt / 1e3 == pytest.approx(30.0, abs=0.1)
    assert position.alt / 1e3 == pytest.approx(DEFAULT_ORIGIN.altitude_amsl_m + home_enu_m[2] + 30.0, abs=0.1)
    sensor = autopilot._build(mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR)
    assert sensor.current_distance / 100 == pytest.approx(home_enu_m[2] + 30.0 - ground_m, abs=0.1)
    assert sensor.orientation == mavlink.MAV_SENSOR_ROTATION_PITCH_270
    pressure = autopilot._build(mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE).press_abs
    assert pressure == pytest.approx(1013.25 * (1 - (position.alt / 1e3) / 44330.77) ** 5.25588, abs=0.02)
    home = autopilot._build(mavlink.MAVLINK_MSG_ID_HOME_POSITION)
    assert home.altitude / 1e3 == pytest.approx(DEFAULT_ORIGIN.altitude_amsl_m + home_enu_m[2], abs=0.01)


def test_a_landing_uphill_slows_down_above_the_ground_there() -> None:
    """ArduCopter slows down 10 m above the ground: the hillside, 12 m above home, is not met at full rate."""
    air = Air("arducopter", TILTED, vehicles=1)
    air.take_off(40.0)
    flight = air.swarm.vehicles[0].autopilot.flight
    flight.fly_to((0.0, 60.0, 40.0), air.swarm.kinematics(1), air.swarm.now.s)
    air.advance(20.0)
    flight.land(air.swarm.kinematics(1), air.swarm.now.s)
    sinking = {}
    while not air.swarm.state.on_ground[0]:
        sinking[round(air.above_ground_m()[0])] = -air.swarm.state.velocity_enu_mps[0, 2]
        air.advance(0.1)
    assert sinking[16] == pytest.approx(1.5, abs=0.1)
    assert max(rate for height_m, rate in sinking.items() if height_m < 8) < 0.6


def test_targets_above_terrain_count_from_the_ground_there() -> None:
    air = Air("arducopter", TILTED, vehicles=1)
    around = Surroundings.of(air.swarm.vehicles[0].autopilot.identity, (0.0, 0.0, 0.0), air.swarm.kinematics(1))
    place = LocalFrame(DEFAULT_ORIGIN).to_geodetic((10.0, 80.0, 0.0))
    wanted_m = DEFAULT_ORIGIN.altitude_amsl_m + float(TILTED.height_m(10.0, 80.0))
    assert around.ground_amsl_m(place.latitude_deg, place.longitude_deg) == pytest.approx(wanted_m, abs=1e-3)


def test_flat_worlds_fly_as_over_a_relief_without_height() -> None:
    """The same steps bit by bit: what relief adds to a flight is nothing where the ground is level."""
    level = Relief(np.zeros((2, 2)), west_m=-500.0, south_m=-500.0, cell_m=1000.0)
    tracks = []
    for relief in (None, level):
        air = Air("arducopter", relief, "rtk")
        air.take_off(20.0)
        for number, vehicle in enumerate(air.swarm.vehicles, start=1):
            vehicle.autopilot.flight.return_home(air.swarm.kinematics(number), air.swarm.now.s)
        air.advance_until_landed(60.0)
        assert air.swarm.report().landed == 3
        tracks.append(np.column_stack([air.swarm.state.position_enu_m, air.swarm.state.attitude_rad]))
    np.testing.assert_array_equal(*tracks)
