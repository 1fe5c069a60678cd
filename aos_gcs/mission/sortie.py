"""One flight of the swarm by one plan."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.landing.return_and_land import ReturnAndLand
from aos_gcs.mission.fleet.reinforcements.joining import Joining
from aos_gcs.mission.fleet.reinforcements.relay import Relay
from aos_gcs.mission.fleet.reinforcements.replacements import Replacements
from aos_gcs.mission.fleet.vehicle_tasks import VehicleTasks
from aos_gcs.mission.launch import Launch
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.preflight.inspection import Inspector
from aos_gcs.mission.preflight.overrides import Overrides
from aos_gcs.mission.search.frames.vision import Vision
from aos_gcs.mission.search.gallery import Gallery
from aos_gcs.mission.search.ground.mapping import GroundMapping
from aos_gcs.mission.search.search import Search
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.settings import MissionSettings


@dataclass(frozen=True, slots=True)
class TakenUp:
    """A flight in the air that a sortie goes on with."""

    limits: SafetyLimits
    """Limits that it flew by."""
    legs: tuple[ScanLeg, ...]
    """Legs of its scan."""
    leg: int
    """Index of the one that was flown last."""
    left_for_later: tuple[LeftPlace, ...]
    """Places that were left for a later look."""


class Sortie:
    """Everything that depends on the plan. Another plan makes another sortie; nothing of the former one stays.

    Args:
        mission: context that stays for the whole mission.
        settings: settings of this plan.
        vehicle_tasks: runs the procedures of single vehicles.
        inspector: asks the vehicles for their settings.
        gallery: shows the pictures.
        findings: findings of the mission.
        ground: map of the searched ground.
        left_for_later: places that the former sortie has left for later.
        focus_override_m: focal height that the operator has set; None leaves it to the program.
        taken_up: the flight in the air that it goes on with; None: its vehicles are to be launched.
    """

    def __init__(
        self,
        mission: MissionContext,
        settings: MissionSettings,
        *,
        vehicle_tasks: VehicleTasks,
        inspector: Inspector,
        gallery: Gallery,
        findings: Findings,
        ground: GroundMapping,
        left_for_later: Sequence[LeftPlace] = (),
        focus_override_m: float | None = None,
        taken_up: TakenUp | None = None,
    ) -> None:
        context = self.context = mission.flight_context(settings, None if taken_up is None else taken_up.limits)
        self.overrides = Overrides(context, mission.recorder)
        self.launch = Launch(context, self.overrides, inspector, mission.auto_start)
        self.vision = Vision(context, mission.recorder, focus_override_m)
        self.replacements = Replacements(context, trusts_names=taken_up is None)
        self.search = Search(
            context,
            mission,
            gallery,
            self.vision,
            findings,
            ground=ground,
            may_be_relieved=self.replacements.may_any_take_off,
            left_for_later=left_for_later if taken_up is None else taken_up.left_for_later,
        )
        if taken_up is not None:
            self.search.decider.progress.take_up(taken_up.legs, taken_up.leg)
        self.return_and_land = ReturnAndLand(context, vehicle_tasks)
        self.joining = Joining(context, vehicle_tasks, inspector, self.launch.check_one)
        self.relay = Relay(
            context,
            self.joining,
            self.return_and_land,
            self.replacements,
            search_left_s=self.search.time_left_s,
        )
        self.handlers: Mapping[Phase, Callable[[], Coroutine[Any, Any, Phase]]] = {
            Phase.CONNECT: self.launch.connect,
            Phase.PREFLIGHT: self.launch.preflight,
            Phase.READY: self.launch.ready,
            Phase.ARM: self.launch.arm,
            Phase.TAKEOFF: self.launch.takeoff,
            Phase.LINE: self.search.line,
            Phase.SCAN: lambda: self.search.make_step(Phase.SCAN),
            Phase.CONVERGE: lambda: self.search.make_step(Phase.CONVERGE),
            Phase.FOUND: lambda: self.search.make_step(Phase.FOUND),
            Phase.RETURN: self.return_and_land.return_home,
            Phase.LAND: self.return_and_land.land,
        }
        """Handler of each phase; it returns the phase that follows."""
