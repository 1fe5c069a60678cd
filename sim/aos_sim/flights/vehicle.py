"""One vehicle behind the port of drivers (``aos_gcs.ports.Vehicle``): ideal link, autopilot and camera, real errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import CommandRefusedError, CommandTimeoutError, NoIntervalError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.heights import AboveHomeM
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.ports import (
    Arm,
    Capture,
    Clock,
    Command,
    Disarm,
    FlightMode,
    Geofence,
    Goto,
    Hold,
    IntervalCaptures,
    Land,
    LandedState,
    ReturnToLaunch,
    Safeguard,
    Takeoff,
    VehicleFacts,
    VehicleState,
)
from aos_gcs.radiometry import celsius_from_centikelvin, centikelvin_from_celsius
from aos_sim.errors.cameras import ErringCameras, View, four_bands
from aos_sim.flights.swarm import FlownSwarm
from aos_sim.vehicle.telemetry import ATMOSPHERE_EXPONENT, ATMOSPHERE_M, SATELLITES, SEA_LEVEL_HPA

BANDS = ("red", "green", "blue", "thermal")
TELEMETRY_S = 0.2
"""Time between two reports."""
LATENCY_S = 0.1
"""Time from a command to the telemetry that shows it."""
DELIVERY_S = 0.6
"""Time from an exposure until its image is there."""
HEIGHT_TOLERANCE_M = 1.0
_RETURN_SETTING = "return height"


class FlownVehicle:
    """A vehicle of a flown swarm.

    Args:
        swarm: motion of all vehicles.
        row: which of them.
        clock: time of the flight.
        frame: frame of the world.
        cameras: errors of the cameras.
        view: what there is to see.
        seed: of the noise of its images.
    """

    def __init__(
        self,
        swarm: FlownSwarm,
        row: int,
        clock: Clock,
        frame: LocalFrame,
        *,
        cameras: ErringCameras,
        view: View,
        seed: int,
    ) -> None:
        self._swarm = swarm
        self._row = row
        self._clock = clock
        self._frame = frame
        self._cameras = cameras
        self._view = view
        self._seed = seed
        self._pilot = swarm.pilots[row]
        self._home = frame.to_geodetic(self._pilot.home_enu_m)
        self._images = 0
        self._orders = 0
        self._fence: Geofence | None = None
        self._return_height_m = 30.0
        self._known: VehicleState | None = None
        self._known_until_s = -math.inf

    @property
    def vehicle_id(self) -> int:
        """System id."""
        return self._row + 1

    @property
    def state(self) -> VehicleState:
        """The latest telemetry."""
        # Read hundreds of times per report.
        if self._known is None or self._clock.now_s() >= self._known_until_s:
            self._swarm.advance()
            self._known, self._known_until_s = self._report(), self._swarm.now_s + TELEMETRY_S
        return self._known

    def _report(self) -> VehicleState:
        swarm, pilot = self._swarm, self._pilot
        kinematics, at_s = swarm.kinematics[self._row], swarm.now_s
        horizontal_m, vertical_m = swarm.position_errors.sizes.accuracy_m
        barometer_m = self._frame.origin.altitude_amsl_m + kinematics.barometer_up_m
        return VehicleState(
            vehicle_id=self.vehicle_id,
            autopilot="arducopter",
            mode=pilot.mode,
            mode_name=pilot.mode.upper(),
            armed=pilot.armed,
            armed_at_s=at_s,
            landed=LandedState.ON_GROUND if kinematics.on_ground else LandedState.IN_AIR,
            landed_at_s=at_s,
            ready_to_arm=True,
            position=kinematics.geodetic,
            position_at_s=at_s,
            height_above_home_m=AboveHomeM(float(kinematics.position_enu_m[2] - pilot.home_enu_m[2])),
            velocity_enu_mps=kinematics.velocity_enu_mps,
            heading_rad=kinematics.heading_rad,
            home=self._home,
            battery_fraction=pilot.battery.remaining,
            battery_at_s=at_s,
            battery_voltage_v=pilot.battery.voltage_v,
            gps_fix=swarm.position_errors.sizes.fix_type,
            satellites=SATELLITES,
            heard_at_s=at_s,
            horizontal_accuracy_m=horizontal_m,
            vertical_accuracy_m=vertical_m,
            gps_altitude_amsl_m=kinematics.receiver_geodetic.altitude_amsl_m,
            pressure_hpa=SEA_LEVEL_HPA * (1.0 - barometer_m / ATMOSPHERE_M) ** ATMOSPHERE_EXPONENT,
            board_id=f"{self.vehicle_id:08x}",
        )

    def reclaim(self) -> None:
        """Do nothing: nobody takes it over."""

    async def execute(self, command: Command, deadline_s: float) -> None:
        """See ``aos_gcs.ports.Vehicle``."""
        self._swarm.advance()
        if reason := self._why_refused(command):
            raise CommandRefusedError(f"vehicle {self.vehicle_id} {reason}")
        self._orders += 1
        order = self._orders
        self._obey(command)
        self._known = None
        await self._clock.sleep(LATENCY_S)
        while not (order == self._orders and self._shows(command)):
            if order != self._orders:
                raise CommandRefusedError(f"vehicle {self.vehicle_id} received another command meanwhile")
            if self._clock.now_s() >= deadline_s:
                raise CommandTimeoutError(f"vehicle {self.vehicle_id} did not get there in time")
            await self._clock.sleep(LATENCY_S)

    def _why_refused(self, command: Command) -> str:
        kinematics, is_armed = self._swarm.kinematics[self._row], self._pilot.armed
        match command:
            case Disarm() if not kinematics.on_ground:
                return "is not on the ground"
            case Takeoff() if not is_armed:
                return "is not armed"
            case Goto(position) if not all(map(math.isfinite, astuple(position))):
                return "cannot go to a position that is not finite"
            case Goto(heading_rad=float(heading_rad)) if not math.isfinite(heading_rad):
                return "cannot turn to a heading that is not finite"
            case Goto() if not is_armed or kinematics.on_ground:
                return "is not flying"
        return ""

    def _obey(self, command: Command) -> None:
        pilot, kinematics = self._pilot, self._swarm.kinematics[self._row]
        here_enu_m = np.array(kinematics.position_enu_m)
        match command:
            case Arm():
                pilot.mode, pilot.armed, pilot.landing = FlightMode.GUIDED, True, False
            case Disarm():
                pilot.armed = pilot.lifting = False
            case Takeoff(height_m):
                pilot.lifting = True
                pilot.fly(FlightMode.GUIDED, np.array([*here_enu_m[:2], pilot.home_enu_m[2] + height_m]))
            case Goto(position, speed_mps, heading_rad):
                pilot.speed_mps = speed_mps
                pilot.heading_rad = pilot.heading_rad if heading_rad is None else heading_rad
                pilot.fly(FlightMode.GUIDED, self._frame.to_enu(position))
            case Hold():
                pilot.fly(FlightMode.HOLD, here_enu_m)
            case ReturnToLaunch():
                height_m = max(here_enu_m[2], pilot.home_enu_m[2] + self._return_height_m)
                pilot.fly(FlightMode.RETURN, np.array([*pilot.home_enu_m[:2], height_m]))
            case Land():
                pilot.mode = FlightMode.LAND
                pilot.descend(kinematics, FlightMode.LAND)

    def _shows(self, command: Command) -> bool:
        if not isinstance(command, Takeoff):
            return True
        self._swarm.advance()
        height_m = self._swarm.kinematics[self._row].position_enu_m[2] - self._pilot.home_enu_m[2]
        return bool(abs(height_m - command.height_above_home_m) <= HEIGHT_TOLERANCE_M)

    async def inspect(self, deadline_s: float) -> VehicleFacts:  # noqa: ARG002 - it answers at once
        """See ``aos_gcs.ports.Vehicle``."""
        on = Safeguard(True, "on")
        return VehicleFacts(
            firmware="simulated",
            board_id=self.state.board_id,
            link_loss=on,
            low_battery=on,
            arming_checks=on,
            other_failsafes=on,
            return_place=on,
            fence=self._fence,
            at_fence=on,
            return_height_m=self._return_height_m,
            return_climb_m=0.0,
            return_settings={_RETURN_SETTING: self._return_height_m},
        )

    async def upload_fence(self, fence: Geofence, deadline_s: float) -> None:  # noqa: ARG002
        """See ``aos_gcs.ports.Vehicle``; it is kept, not enforced."""
        self._fence = fence

    async def set_return_height(self, height_above_home_m: AboveHomeM, deadline_s: float) -> None:  # noqa: ARG002
        """See ``aos_gcs.ports.Vehicle``."""
        self._return_height_m = height_above_home_m

    async def restore_return(self, settings: Mapping[str, float], deadline_s: float) -> None:  # noqa: ARG002
        """See ``aos_gcs.ports.Vehicle``."""
        self._return_height_m = settings[_RETURN_SETTING]

    async def capture(self, deadline_s: float) -> Capture:  # noqa: ARG002 - it is always there in time
        """See ``aos_gcs.ports.Vehicle``."""
        self._swarm.advance()
        index, camera = self._images, self._cameras.camera
        self._images += 1
        kinematics, elapsed_s = self._swarm.kinematics[self._row], self._swarm.elapsed_s
        rng = np.random.default_rng((self._seed, self.vehicle_id, index))
        frame = self._cameras.expose(
            self._view, self._swarm.motion(self._row), rng, camera_id=self.vehicle_id, index=index, at_s=elapsed_s
        )
        reported = nadir_pose(np.array(kinematics.position_enu_m), kinematics.heading_rad)
        utc_s = self._clock.utc_s()
        await self._clock.sleep(DELIVERY_S)
        return Capture(
            vehicle_id=self.vehicle_id,
            image_index=index,
            utc_s=utc_s,
            image=_as_stored(four_bands(frame)),
            bands=BANDS,
            position=kinematics.geodetic,
            R_cam2enu=reported.R_cam2enu,
            camera=camera,
        )

    def interval(self, period_s: float, deadline_s: float) -> AbstractAsyncContextManager[IntervalCaptures]:  # noqa: ARG002
        """See ``aos_gcs.ports.Vehicle``."""
        raise NoIntervalError("the camera has none")


def _as_stored(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return an image as it comes out of a file, with temperatures in steps of 0.01 K."""
    image[..., 3] = celsius_from_centikelvin(centikelvin_from_celsius(image[..., 3]))
    return image
