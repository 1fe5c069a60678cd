"""Vehicles that hover where they believe to have been sent: for worlds that only see them at their exposures."""

from __future__ import annotations

import numpy as np

from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_sim.errors.attitude import AttitudeProcess
from aos_sim.errors.exposure import Motion
from aos_sim.errors.model import ErrorModel
from aos_sim.errors.position import PositionProcess
from aos_sim.errors.sizes import FloatArray


class Hover:
    """Poses of n hovering vehicles. Positions and headings err by the same amount for as long as the scene lasts.

    Args:
        model: errors of the vehicles; its wind moves them.
        vehicles: n.
        seed: of the draws; models with equal seeds err in the same directions.
    """

    def __init__(self, model: ErrorModel, vehicles: int, seed: int) -> None:
        self._wind = model.wind
        self.position_error_enu_m = PositionProcess(model.position, vehicles, seed).estimate_enu_m
        """What each vehicle believes minus where it is, shape (n, 3)."""
        self.heading_error_rad = AttitudeProcess(model.attitude, vehicles, seed).estimate_rad[:, 2]

    def motion(self, vehicle: int, waypoint_enu_m: FloatArray, heading_rad: float, rng: np.random.Generator) -> Motion:
        """Return the true motion of a vehicle that was sent to a waypoint; ``rng`` draws the gusts."""
        gust_mps = rng.standard_normal(3) * self._wind.gust_sigma_mps
        return Motion(
            position_enu_m=waypoint_enu_m - self.position_error_enu_m[vehicle],
            heading_rad=heading_rad - float(self.heading_error_rad[vehicle]),
            velocity_enu_mps=self._wind.response * gust_mps,
        )

    def reported(self, vehicle: int, true: Motion) -> Pose:
        """Return the pose that a vehicle reports of its camera, which it takes to look straight down."""
        position_enu_m = true.position_enu_m + self.position_error_enu_m[vehicle]
        return nadir_pose(position_enu_m, true.heading_rad + float(self.heading_error_rad[vehicle]))
