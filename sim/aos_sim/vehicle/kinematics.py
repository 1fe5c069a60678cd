"""Sensor readings of each vehicle from the true state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pymap3d
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.vehicle.dynamics import SwarmState

EnuPoint = tuple[float, float, float]


class GeodeticTable:
    """Geodetic positions of all vehicles at one instant, calculated together when the first is asked for.

    Most ticks need none; the conversion costs as much as the rest of a tick.
    """

    def __init__(self, position_enu_m: NDArray[np.float64], frame: LocalFrame) -> None:
        self._position_enu_m = position_enu_m
        self._origin = frame.origin
        self._rows: list[GeodeticPosition] | None = None

    def __getitem__(self, row: int) -> GeodeticPosition:
        if self._rows is None:
            origin = self._origin
            columns = pymap3d.enu2geodetic(
                *self._position_enu_m.T, origin.latitude_deg, origin.longitude_deg, origin.altitude_amsl_m
            )
            self._rows = [GeodeticPosition(*row) for row in np.column_stack(columns).tolist()]
        return self._rows[row]


@dataclass(frozen=True, slots=True)
class Kinematics:
    """The motion of one vehicle at one instant."""

    position_enu_m: EnuPoint
    velocity_enu_mps: EnuPoint
    roll_rad: float
    pitch_rad: float
    heading_rad: float
    """Clockwise from north, [0, 2 pi)."""
    rates_radps: EnuPoint
    """Rates of roll, pitch and heading."""
    on_ground: bool
    table: GeodeticTable
    row: int
    """Place of the vehicle in ``table``."""

    @property
    def geodetic(self) -> GeodeticPosition:
        """The position on the globe."""
        return self.table[self.row]


def read_kinematics(state: SwarmState, frame: LocalFrame) -> list[Kinematics]:
    """Return what each vehicle's sensors say of the true state."""
    table = GeodeticTable(state.position_enu_m, frame)
    rows = zip(
        state.position_enu_m.tolist(),
        state.velocity_enu_mps.tolist(),
        state.attitude_rad.tolist(),
        state.attitude_rates_radps.tolist(),
        state.on_ground.tolist(),
        strict=True,
    )
    return [
        Kinematics(
            position_enu_m=tuple(position),
            velocity_enu_mps=tuple(velocity),
            roll_rad=roll_rad,
            pitch_rad=pitch_rad,
            heading_rad=heading_rad,
            rates_radps=tuple(rates),
            on_ground=on_ground,
            table=table,
            row=row,
        )
        for row, (position, velocity, (roll_rad, pitch_rad, heading_rad), rates, on_ground) in enumerate(rows)
    ]
