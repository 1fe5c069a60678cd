"""Motion of a swarm by plain set-points: dynamics, errors of the sensors, and ideal autopilots."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.ports import Clock, FlightMode
from aos_sim.errors.attitude import AttitudeProcess
from aos_sim.errors.exposure import Motion
from aos_sim.errors.model import ErrorModel
from aos_sim.errors.position import PositionProcess
from aos_sim.report import ClearanceMonitor, SeparationMonitor
from aos_sim.vehicle.battery import Battery
from aos_sim.vehicle.dynamics import AirframeLimits, Guidance, SwarmState, step
from aos_sim.vehicle.kinematics import Kinematics, read_kinematics
from aos_sim.world.relief import Relief, ground_below

STEP_S = 0.1
"""Step of the dynamics."""
CLIMB_MPS = 2.5
DESCENT_MPS = 1.5
LANDING_MPS = 0.5
"""Descent near the ground."""
SLOW_BELOW_M = 5.0
UNDERGROUND_M = -5.0
"""Height above the ground of the set-point of a vehicle that lands."""
HOME_RADIUS_M = 0.5
_ROUNDING_S = 1e-6
HEADING_SIGMA_RAD = math.radians(5.0)
"""Vehicles are not put down perfectly aligned."""


@dataclass(slots=True)
class Pilot:
    """Ideal autopilot of one vehicle: it flies to its set-point by the position that it believes."""

    home_enu_m: NDArray[np.float64]
    """Place where it stands as it believes, shape (3,)."""
    heading_rad: float
    target_enu_m: NDArray[np.float64]
    battery: Battery
    mode: FlightMode = FlightMode.GUIDED
    armed: bool = False
    lifting: bool = False
    landing: bool = False
    """Whether it comes down to the ground."""
    speed_mps: float = 10.0

    def update(self, kinematics: Kinematics) -> None:
        """Go on with a return or a landing."""
        here_enu_m = np.array(kinematics.position_enu_m)
        if self.mode is FlightMode.RETURN and math.dist(here_enu_m[:2], self.home_enu_m[:2]) <= HOME_RADIUS_M:
            self.descend(kinematics, FlightMode.RETURN)
        if self.landing and kinematics.on_ground:
            self.armed = self.lifting = False
        self.battery.drain(self.armed, self.lifting, STEP_S)

    def fly(self, mode: FlightMode, target_enu_m: NDArray[np.float64]) -> None:
        """Fly to a place."""
        self.mode, self.target_enu_m, self.landing = mode, target_enu_m, False

    def descend(self, kinematics: Kinematics, mode: FlightMode) -> None:
        """Come down where it is."""
        if not self.landing:
            below_m = kinematics.ground_up_m + UNDERGROUND_M
            self.fly(mode, np.array([*kinematics.position_enu_m[:2], below_m]))
            self.landing = True


class FlownSwarm:
    """The vehicles of a flight. Nothing runs beside the caller: :meth:`advance` computes what has passed on the clock.

    Args:
        clock: time of the flight; its begin is now.
        frame: frame of the world.
        homes_enu_m: places where the vehicles stand, shape (n, 3).
        errors: errors of positions and attitudes, and the wind.
        seed: of all draws.
        relief: shape of the ground; None: the plane z = 0.
        battery: battery of each vehicle; None: the usual one.
    """

    def __init__(
        self,
        clock: Clock,
        frame: LocalFrame,
        homes_enu_m: NDArray[np.float64],
        errors: ErrorModel,
        seed: int,
        *,
        relief: Relief | None = None,
        battery: Battery | None = None,
    ) -> None:
        self._relief = relief
        self._clock = clock
        self._frame = frame
        self._rng = np.random.default_rng(seed)
        self._wind = errors.wind
        self._limits = AirframeLimits()
        self._begin_s = self._until_s = clock.now_s()
        self._steps = 0
        headings_rad = self._rng.normal(0.0, HEADING_SIGMA_RAD, len(homes_enu_m))
        self._state = SwarmState.at_rest(homes_enu_m, headings_rad)
        self.position_errors = PositionProcess(errors.position, len(homes_enu_m), seed)
        self._attitude_errors = AttitudeProcess(errors.attitude, len(homes_enu_m), seed)
        self._ids = range(1, len(homes_enu_m) + 1)
        self._separation = SeparationMonitor()
        self._clearance = ClearanceMonitor(homes_enu_m, relief)
        self.kinematics = self._read()
        full = Battery() if battery is None else battery
        self.pilots = [
            Pilot(np.array(one.position_enu_m), one.heading_rad, np.array(one.position_enu_m), replace(full))
            for one in self.kinematics
        ]

    @property
    def now_s(self) -> float:
        """Clock time of the latest step."""
        return self._until_s

    @property
    def elapsed_s(self) -> float:
        """Time since the vehicles were switched on."""
        return self._steps * STEP_S

    @property
    def min_separation_m(self) -> float | None:
        """Smallest true 3-D distance of two vehicles so far."""
        self.advance()
        return self._separation.smallest_m

    @property
    def min_height_above_ground_m(self) -> float | None:
        """Smallest true height of a vehicle above the ground so far, away from its launch point."""
        self.advance()
        return self._clearance.smallest_m

    @property
    def landed(self) -> int:
        """Number of vehicles that stand on the ground, disarmed."""
        self.advance()
        return sum(one.on_ground and not pilot.armed for one, pilot in zip(self.kinematics, self.pilots, strict=True))

    def motion(self, row: int) -> Motion:
        """Return the true motion of a vehicle, for its camera."""
        return Motion(
            position_enu_m=self._state.position_enu_m[row],
            heading_rad=float(self._state.attitude_rad[row, 2]),
            velocity_enu_mps=self._state.velocity_enu_mps[row],
            rates_radps=self.kinematics[row].rates_radps,
        )

    def advance(self) -> None:
        """Let the vehicles fly until now."""
        now_s = self._clock.now_s()
        while self._until_s + STEP_S <= now_s + _ROUNDING_S:
            self._step()

    def _step(self) -> None:
        self._steps += 1
        self._until_s = self._begin_s + self._steps * STEP_S
        self.position_errors.advance(STEP_S)
        self._attitude_errors.advance(STEP_S)
        self._state = step(
            self._state,
            self._guidance(),
            STEP_S,
            limits=self._limits,
            wind=self._wind,
            rng=self._rng,
            relief=self._relief,
        )
        self.kinematics = self._read()
        self._separation.update(self._ids, self._state.position_enu_m)
        self._clearance.update(self._state.position_enu_m)
        for pilot, kinematics in zip(self.pilots, self.kinematics, strict=True):
            pilot.update(kinematics)

    def _read(self) -> list[Kinematics]:
        return read_kinematics(
            self._state, self._frame, self.position_errors, self._attitude_errors, relief=self._relief
        )

    def _guidance(self) -> Guidance:
        """Return the set-points in true positions and headings: an autopilot that errs flies elsewhere."""
        heights_m = self._state.position_enu_m[:, 2] - ground_below(self._state.position_enu_m, self._relief)
        targets_enu_m = np.array([pilot.target_enu_m for pilot in self.pilots])
        lands_slowly = np.array([pilot.landing for pilot in self.pilots]) & (heights_m < SLOW_BELOW_M)
        return Guidance(
            lifting=np.array([pilot.lifting for pilot in self.pilots]),
            target_enu_m=targets_enu_m - self.position_errors.steered_enu_m,
            speed_mps=np.array([pilot.speed_mps for pilot in self.pilots]),
            climb_mps=np.full(len(self.pilots), CLIMB_MPS),
            descent_mps=np.where(lands_slowly, LANDING_MPS, DESCENT_MPS),
            heading_rad=np.array([pilot.heading_rad for pilot in self.pilots])
            - self._attitude_errors.estimate_rad[:, 2],
        )
