"""A bench that flies one autopilot in simulated time, without sockets."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.camera.component import CameraComponent
from aos_sim.clock import TICK_S, SimTime
from aos_sim.errors.wind import Wind
from aos_sim.packets import Parser
from aos_sim.swarm import AUTOPILOTS
from aos_sim.vehicle.configuration import VehicleIdentity
from aos_sim.vehicle.dynamics import AirframeLimits, Guidance, SwarmState, step
from aos_sim.vehicle.kinematics import Kinematics, read_kinematics
from aos_sim.vehicle.vehicle import SimulatedVehicle

SYSTEM_ID = 7
GCS_ID = 254
ORIGIN = GeodeticPosition(48.3, 14.3, 260.0)
ACCEPTED = mavlink.MAV_RESULT_ACCEPTED
GUIDED = 4


class Bench:
    """One vehicle with its dynamics; what it has sent is in ``sent``."""

    def __init__(self, flavour: str, parameters: Mapping[str, float], start_up_s: float, wind_mps: float) -> None:
        self.flavour = flavour
        self.frame = LocalFrame(ORIGIN)
        self._wind = Wind(wind_mps)
        self._rng = np.random.default_rng(1)
        self.state = SwarmState.at_rest(np.zeros((1, 3)), np.array([0.2]))
        self.now = SimTime(0, start_utc_us=1_700_000_000_000_000)
        identity = VehicleIdentity(SYSTEM_ID, self.frame, uid=1234, start_up_s=start_up_s, parameters=parameters)
        camera = CameraComponent(SYSTEM_ID, CameraModel.from_fov(64, 48, 0.9))
        self.vehicle = SimulatedVehicle(AUTOPILOTS[flavour](identity, self.kinematics), camera)
        self.autopilot = self.vehicle.autopilot
        self.camera = camera
        self.sent: list[Any] = []
        self._parser = Parser()
        self.heartbeats_from: int | None = None
        self.step_ticks = 5
        """Ticks per step of the dynamics, as at five times the speed; no message is sent more often."""

    @property
    def kinematics(self) -> Kinematics:
        return read_kinematics(self.state, self.frame)[0]

    @property
    def height_m(self) -> float:
        return float(self.state.position_enu_m[0, 2])

    def advance(self, seconds: float) -> None:
        """Let time pass, in steps that end at multiples of ``step_ticks``."""
        end = self.now.tick + round(seconds / TICK_S)
        while self.now.tick < end:
            if self.heartbeats_from is not None and self.now.tick % 50 == 0:
                self.heartbeat(self.heartbeats_from)
            ticks = min(self.step_ticks - self.now.tick % self.step_ticks, end - self.now.tick)
            self.now = self.now.later(ticks)
            setpoint = self.autopilot.setpoint
            guidance = Guidance(
                lifting=np.array([setpoint.lifting]),
                target_enu_m=np.array([setpoint.target_enu_m]),
                speed_mps=np.array([setpoint.speed_mps]),
                climb_mps=np.array([setpoint.climb_mps]),
                descent_mps=np.array([setpoint.descent_mps]),
                heading_rad=np.array([setpoint.heading_rad]),
            )
            duration_s = ticks * TICK_S
            self.state = step(self.state, guidance, duration_s, limits=AirframeLimits(), wind=self._wind, rng=self._rng)
            self.vehicle.update(self.kinematics, self.now)
            self._collect()

    def lift_to(self, height_m: float) -> None:
        """Put a climbing vehicle so high at once, which saves the time of its climb."""
        self.state = replace(self.state, position_enu_m=np.array([[0.0, 0.0, height_m]]))

    def silence(self) -> None:
        """End the streams that PX4 sends unasked: packing and parsing them is most of the work of a flight."""
        for message_id in {message.get_msgId() for message in self.sent} - {mavlink.MAVLINK_MSG_ID_HEARTBEAT}:
            self.long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, -1)

    def advance_until(self, condition: Callable[[], bool], limit_s: float) -> float:
        """Advance until the condition holds and return how long that took."""
        start_s = self.now.s
        while not condition():
            assert self.now.s - start_s < limit_s, "the condition never came true"
            self.advance(0.1)
        return self.now.s - start_s

    def send(self, message: Any, system_id: int = GCS_ID) -> list[Any]:
        """Send over the wire format and return what came back at once."""
        before = len(self.sent)
        codec = mavlink.MAVLink(None, system_id, 190)
        for parsed in Parser().feed(message.pack(codec)):
            self.vehicle.handle(parsed, self.kinematics, self.now)
        self._collect()
        return self.sent[before:]

    def heartbeat(self, system_id: int = GCS_ID) -> None:
        kind = (mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3)
        self.send(mavlink.MAVLink_heartbeat_message(*kind), system_id)

    def long(self, command: int, *params: float, system: int = SYSTEM_ID, component: int = 1) -> list[int]:
        """Send a COMMAND_LONG and return the results acknowledged."""
        seven = (*params, *[0.0] * (7 - len(params)))
        return self._acks(
            self.send(mavlink.MAVLink_command_long_message(system, component, command, 0, *seven)), command
        )

    def reposition(
        self,
        east_m: float,
        north_m: float,
        up_m: float,
        *,
        speed: float = -1.0,
        flags: float = 1.0,
        yaw: float = float("nan"),
        frame: int = mavlink.MAV_FRAME_GLOBAL_INT,
        altitude: float | None = None,
    ) -> list[int]:
        """Send a DO_REPOSITION as COMMAND_INT and return the results acknowledged."""
        place = self.frame.to_geodetic((east_m, north_m, up_m))
        message = mavlink.MAVLink_command_int_message(
            SYSTEM_ID,
            1,
            frame,
            mavlink.MAV_CMD_DO_REPOSITION,
            0,
            0,
            speed,
            flags,
            0.0,
            yaw,
            round(place.latitude_deg * 1e7),
            round(place.longitude_deg * 1e7),
            place.altitude_amsl_m if altitude is None else altitude,
        )
        return self._acks(self.send(message), mavlink.MAV_CMD_DO_REPOSITION)

    def set_parameter(self, name: str, value: float) -> Any:
        message = mavlink.MAVLink_param_set_message(SYSTEM_ID, 1, name.encode(), value, 9)
        return self.send(message)

    def last(self, name: str) -> Any:
        return next(message for message in reversed(self.sent) if message.get_type() == name)

    def request(self, message_id: int) -> Any:
        """Ask for one message and return it."""
        replies = self.send(
            mavlink.MAVLink_command_long_message(
                SYSTEM_ID, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, message_id, 0, 0, 0, 0, 0, 0
            )
        )
        return next(message for message in replies if message.get_msgId() == message_id)

    def count(self, name: str) -> int:
        return sum(message.get_type() == name for message in self.sent)

    def texts(self) -> list[str]:
        return [message.text for message in self.sent if message.get_type() == "STATUSTEXT"]

    def distance_to(self, *point_enu_m: float) -> float:
        return float(np.linalg.norm(self.state.position_enu_m[0] - point_enu_m))

    def _collect(self) -> None:
        self.sent += self._parser.feed(self.vehicle.drain())

    @staticmethod
    def _acks(replies: list[Any], command: int) -> list[int]:
        return [m.result for m in replies if m.get_type() == "COMMAND_ACK" and m.command == command]


@pytest.fixture(scope="session")
def make_bench() -> Callable[..., Bench]:
    """Return a maker of benches: flavour, then parameters by name."""

    def make(flavour: str, start_up_s: float = 0.0, wind_mps: float = 0.0, **parameters: float) -> Bench:
        bench = Bench(flavour, parameters, start_up_s, wind_mps)
        bench.advance(0.1)
        return bench

    return make


@pytest.fixture(scope="session")
def make_flying(make_bench: Callable[..., Bench]) -> Callable[[str], Bench]:
    """Return a maker of vehicles of a flavour that have just taken off and hover 20 m above home."""

    def make(flavour: str) -> Bench:
        bench = make_bench(flavour)
        altitude_m = 20.0
        if flavour == "px4":
            bench.heartbeats_from = GCS_ID
            bench.advance(1.1)
            bench.silence()
            altitude_m += ORIGIN.altitude_amsl_m
        else:
            assert bench.long(mavlink.MAV_CMD_DO_SET_MODE, 1, GUIDED) == [ACCEPTED]
        assert bench.long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == [ACCEPTED]
        assert bench.long(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, *[math.nan] * 3, altitude_m) == [ACCEPTED]
        bench.advance_until(lambda: bench.height_m > 0.1, 20)
        bench.lift_to(19.0)
        bench.advance(3.0)
        assert bench.height_m == pytest.approx(20.0, abs=0.3)
        return bench

    return make
