"""Sensor readings of each vehicle from the true state and the errors of the sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.errors.attitude import AttitudeProcess
from aos_sim.errors.model import RTK
from aos_sim.errors.position import PositionErrors, PositionProcess
from aos_sim.vehicle.dynamics import SwarmState
from aos_sim.world.relief import Relief, ground_below

EnuPoint = tuple[float, float, float]


class GeodeticTable:
    """Geodetic positions of all vehicles at one instant, each calculated when it is asked for: most ticks need none."""

    def __init__(self, position_enu_m: NDArray[np.float64], frame: LocalFrame) -> None:
        self._position_enu_m = position_enu_m
        self._frame = frame
        self._rows: dict[int, GeodeticPosition] = {}

    def __getitem__(self, row: int) -> GeodeticPosition:
        if row not in self._rows:
            self._rows[row] = self._frame.to_geodetic(self._position_enu_m[row])
        return self._rows[row]


@dataclass(frozen=True, slots=True)
class Kinematics:
    """The motion of one vehicle at one instant, as its autopilot believes it, and what its other sensors read."""

    position_enu_m: EnuPoint
    """Position that the autopilot estimates and flies by."""
    true_enu_m: EnuPoint
    velocity_enu_mps: EnuPoint
    roll_rad: float
    pitch_rad: float
    heading_rad: float
    """Clockwise from north, [0, 2 pi); as are roll and pitch, what the autopilot estimates."""
    true_attitude_rad: EnuPoint
    """True roll, pitch and heading."""
    rates_radps: EnuPoint
    """Rates of roll, pitch and heading."""
    on_ground: bool
    table: GeodeticTable
    true_table: GeodeticTable
    receiver_table: GeodeticTable
    row: int
    """Place of the vehicle in the tables."""
    barometer_up_m: float
    """Height above the world's origin that the barometer measures."""
    errors: PositionErrors
    """Sizes of the position's errors."""
    ground_up_m: float = 0.0
    """Height of the ground below the vehicle above the world's origin."""

    @property
    def range_m(self) -> float:
        """Height above the ground that a rangefinder measures."""
        return max(self.true_enu_m[2] - self.ground_up_m, 0.0)

    @property
    def geodetic(self) -> GeodeticPosition:
        """The estimated position on the globe."""
        return self.table[self.row]

    @property
    def true_geodetic(self) -> GeodeticPosition:
        """The true position on the globe."""
        return self.true_table[self.row]

    @property
    def receiver_geodetic(self) -> GeodeticPosition:
        """The position on the globe that the satellite receiver measures."""
        return self.receiver_table[self.row]


def read_kinematics(
    state: SwarmState,
    frame: LocalFrame,
    process: PositionProcess | None = None,
    attitudes: AttitudeProcess | None = None,
    *,
    relief: Relief | None = None,
) -> list[Kinematics]:
    """Return what each vehicle's sensors say of the true state; without errors where there is no ``process``.

    Args:
        state: true state.
        frame: local frame of the world.
        process: errors of the positions.
        attitudes: errors of the attitudes.
        relief: shape of the ground; None: the plane z = 0.
    """
    true_table = GeodeticTable(state.position_enu_m, frame)
    believed_enu_m, barometer_up_m = state.position_enu_m, state.position_enu_m[:, 2]
    table = receiver_table = true_table
    if process is not None:
        believed_enu_m = state.position_enu_m + process.estimate_enu_m
        barometer_up_m = barometer_up_m + process.barometer_m
        table = GeodeticTable(believed_enu_m, frame)
        receiver_table = GeodeticTable(state.position_enu_m + process.receiver_enu_m, frame)
    errors = RTK.position if process is None else process.sizes
    attitude_rad = state.attitude_rad if attitudes is None else _believed(state.attitude_rad, attitudes)
    rows = zip(
        believed_enu_m.tolist(),
        state.position_enu_m.tolist(),
        state.velocity_enu_mps.tolist(),
        attitude_rad.tolist(),
        state.attitude_rad.tolist(),
        state.attitude_rates_radps.tolist(),
        state.on_ground.tolist(),
        barometer_up_m.tolist(),
        ground_below(state.position_enu_m, relief).tolist(),
        strict=True,
    )
    return [
        Kinematics(
            position_enu_m=tuple(position),
            true_enu_m=tuple(true),
            velocity_enu_mps=tuple(velocity),
            roll_rad=roll_rad,
            pitch_rad=pitch_rad,
            heading_rad=heading_rad,
            true_attitude_rad=tuple(true_attitude),
            rates_radps=tuple(rates),
            on_ground=on_ground,
            table=table,
            true_table=true_table,
            receiver_table=receiver_table,
            row=row,
            barometer_up_m=barometer_m,
            errors=errors,
            ground_up_m=ground_up_m,
        )
        for row, (
            position,
            true,
            velocity,
            (roll_rad, pitch_rad, heading_rad),
            true_attitude,
            rates,
            on_ground,
            barometer_m,
            ground_up_m,
        ) in enumerate(rows)
    ]


def _believed(attitude_rad: NDArray[np.float64], attitudes: AttitudeProcess) -> NDArray[np.float64]:
    """Return roll, pitch and heading as the autopilots estimate them, shape (n, 3)."""
    believed_rad = attitude_rad + attitudes.estimate_rad
    believed_rad[:, 2] %= 2.0 * np.pi
    return believed_rad
