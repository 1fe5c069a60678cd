"""What pilots and operators do."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_sim.vehicle.arducopter import CopterMode
from aos_sim.vehicle.px4_modes import Px4Mode
from tests.campaign.faults.base import Basis, Fault, draw_duration, draw_time
from tests.campaign.world import World

MANUAL_MODES: Mapping[str, tuple[int, ...]] = {
    "arducopter": (CopterMode.ALT_HOLD, CopterMode.STABILIZE),
    "px4": (Px4Mode.POSITION, Px4Mode.ALTITUDE),
}
HOVERING_MODES: Mapping[str, tuple[int, ...]] = {
    "arducopter": (CopterMode.LOITER, CopterMode.POSHOLD, CopterMode.BRAKE),
    "px4": (Px4Mode.HOLD,),
}
"""Modes that the station uses to hold, too."""
INSISTS_AFTER_S = 2.0
"""Time after which a pilot chooses a mode again that a command has ended, sent before a heartbeat could show it."""
NEAR_TOP_M = 3.0
"""The station's tolerance of a take-off's height, and the climb while the vehicle brakes."""


@dataclass(frozen=True)
class PilotTakesOver(Fault):
    """A pilot takes a vehicle over, hovers, and lands it."""

    MODES: ClassVar[Mapping[str, tuple[int, ...]]] = MANUAL_MODES

    vehicle_id: int
    mode: int
    duration_s: float

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        mode = int(rng.choice(cls.MODES[basis.autopilot]))
        return cls(draw_time(rng), basis.draw_vehicle(rng), mode, draw_duration(rng, 3.0, 40.0))

    async def act(self, world: World) -> None:
        vehicle = world.swarm.vehicle(self.vehicle_id)
        if not vehicle.autopilot.flight.airborne or world.oracle.has_fallen(self.vehicle_id):
            return
        autopilot = vehicle.autopilot
        if self.mode == autopilot.custom_mode():
            return  # the mode that the station flies or holds it in: the choice changes nothing, and nothing shows it
        height_m = autopilot.kinematics.position_enu_m[2]
        if self.mode == Px4Mode.HOLD and height_m > autopilot.flight.target_enu_m[2] - NEAR_TOP_M:
            return  # stops where PX4 enters this mode by itself at the end of a take-off
        with world.oracle.piloted(self.vehicle_id):
            autopilot.select_mode(self.mode)
            await world.sleep(INSISTS_AFTER_S)
            if autopilot.flight.armed and autopilot.custom_mode() != self.mode:
                autopilot.select_mode(self.mode)
            await world.sleep(self.duration_s - INSISTS_AFTER_S)
            autopilot.select_mode(autopilot.land_mode())
            while vehicle.autopilot.flight.armed and world.swarm.vehicle(self.vehicle_id) is vehicle:
                await world.sleep(1.0)


@dataclass(frozen=True)
class PilotHovers(PilotTakesOver):
    """A pilot takes a vehicle over by a mode that the station uses to hold, too."""

    MODES: ClassVar[Mapping[str, tuple[int, ...]]] = HOVERING_MODES


@dataclass(frozen=True)
class OperatorActs(Fault):
    """An operator presses a button, whatever comes of it."""

    WEIGHT: ClassVar[float] = 3.0

    action: Action
    vehicle_id: int | None
    """None: for all."""

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: Basis) -> Self:
        actions = [Action.HOLD, Action.RESUME, Action.PAUSE, Action.RETURN, Action.LAND, Action.ABORT, Action.JOIN]
        action = actions[int(rng.choice(len(actions), p=[0.25, 0.2, 0.1, 0.15, 0.15, 0.1, 0.05]))]
        vehicle_id = None if rng.random() < 0.5 else basis.draw_vehicle(rng)
        return cls(draw_time(rng), action, vehicle_id)

    async def act(self, world: World) -> None:
        if world.station is None or world.oracle.is_piloted(self.vehicle_id):
            return
        vehicle_ids = None if self.vehicle_id is None else (self.vehicle_id,)
        with suppress(MissionError):  # refused, with a reason
            await world.station.mission.commands.act(self.action, vehicle_ids, operator="campaign")
