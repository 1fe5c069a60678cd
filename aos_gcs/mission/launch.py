"""From the first heartbeat to everybody hovering in its altitude layer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aos_gcs.errors import MissionFailedError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.aperture_check import check_aperture
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.model import Phase, PreflightCheck, Task
from aos_gcs.mission.overrides import Overrides
from aos_gcs.mission.plan import altitude_layers, propose_fence
from aos_gcs.mission.preflight import MIN_HOME_DISTANCE_M, check_all, check_area
from aos_gcs.mission.roster import Member
from aos_gcs.mission.safety import SafetyLimits
from aos_gcs.ports import Arm, Disarm, Severity, Takeoff

MIN_SWARM = 2
_POLL_S = 0.5
_FENCE_MARGIN_M = 30.0
_LAYER_MARGIN_M = 5.0
"""Between the lowest and highest layers and the floor and ceiling that are proposed around them."""


class Launch:
    """The phases CONNECT to TAKEOFF. Every handler can be entered again after an interruption."""

    def __init__(self, context: MissionContext, overrides: Overrides) -> None:
        self._context = context
        self._overrides = overrides
        self._advice = check_aperture(context.settings)

    async def connect(self) -> Phase:
        """Wait until the expected number of vehicles is heard."""
        context = self._context
        expected, deadlines = context.settings.vehicles, context.settings.deadlines
        deadline_s = context.clock.now_s() + deadlines.connect_s
        while len(heard := context.roster.members()) < expected:
            self._find_origin()
            context.message = f"Waiting for vehicles: {len(heard)} of {expected} heard."
            if context.settings.area_enu_m and context.clock.now_s() > deadline_s:
                raise MissionFailedError(
                    f"Only {len(heard)} of {expected} vehicles were heard within {deadlines.connect_s:.0f} s; "
                    "check that they are switched on and send to this computer's address and port."
                )
            await context.clock.sleep(_POLL_S)
        return Phase.PREFLIGHT

    async def preflight(self) -> Phase:
        """Wait until no check of any vehicle stands against the launch."""
        context = self._context
        deadline_s = context.clock.now_s() + context.settings.deadlines.preflight_s
        while not await self._checks_pass():
            failed = [check for check in context.preflight if check.blocks]
            context.message = f"Preflight: {len(failed)} checks open; {failed[0].describe()}."
            if context.settings.auto_start and context.clock.now_s() > deadline_s:
                raise MissionFailedError(f"Preflight did not pass in time. {context.message}")
            await context.clock.sleep(_POLL_S)
        self._assign_layers()
        return Phase.READY

    async def ready(self) -> Phase:
        """Wait for the operator's start, which redirects to ARM; fall back to preflight when a check fails again."""
        context = self._context
        overridden = sum(check.overridden is not None for check in context.preflight)
        passed = f"{overridden} failed checks are overridden" if overridden else "all checks passed"
        context.message = f"Ready: {passed}, waiting for start."
        while await self._checks_pass():
            if context.settings.auto_start:
                return Phase.ARM
            await context.clock.sleep(_POLL_S)
        return Phase.PREFLIGHT

    async def arm(self) -> Phase:
        """Start the motors of all vehicles; those that refuse stay behind."""
        context = self._context
        context.message = "Arming."
        # Entered again after a long hold, autopilots have stopped motors that were idle.
        unarmed = [m for m in context.roster.members(Task.IDLE, Task.SWARM) if not m.state.armed]
        refusals = await context.flight.command_each(unarmed, lambda _: Arm())
        for member in context.roster.select(vehicle_id for vehicle_id, reason in refusals.items() if reason is None):
            member.task = Task.SWARM
        swarm = context.roster.members(Task.SWARM)
        if len(swarm) < MIN_SWARM:
            await context.flight.command_each(swarm, lambda _: Disarm())
            raise MissionFailedError(f"Only {len(swarm)} vehicle armed; a swarm needs at least {MIN_SWARM}.")
        return Phase.TAKEOFF

    async def takeoff(self) -> Phase:
        """Climb vertically, each vehicle to its own layer; those that do not get there return alone."""
        context = self._context
        context.message = "Climbing to the altitude layers."
        swarm = context.roster.members(Task.SWARM)
        grounded = [member for member in swarm if not member.airborne]
        await context.flight.command_each([m for m in grounded if not m.state.armed], lambda _: Arm())
        await context.flight.command_each(grounded, self._takeoff, context.settings.deadlines.takeoff_s)
        interrupted = {
            member.vehicle_id: column_enu_m
            for member in swarm
            if member.airborne
            and not context.roster.is_in_layer(member)
            and (column_enu_m := context.roster.own_column_enu_m(member)) is not None
        }
        await context.flight.transfer(interrupted, frozenset({Task.SWARM}))
        for member in swarm:
            if member.task is not Task.SWARM or context.roster.is_in_layer(member):
                continue
            member.task = Task.HELD
            context.journal.notice(
                Severity.WARNING, "did not reach its altitude layer and is left out of the swarm", member.vehicle_id
            )
        return Phase.LINE

    async def check_one(self, member: Member) -> tuple[PreflightCheck, ...]:
        """Return the checks of one vehicle as they are now, such as of one that is to join in mid-mission."""
        context = self._context
        separation_m = context.settings.safety.get("separation_m", MIN_HOME_DISTANCE_M)
        found = check_all(context.roster, context.settings.vehicles, separation_m)
        return await self._overrides.apply(check for check in found if check.vehicle_id == member.vehicle_id)

    async def _checks_pass(self) -> bool:
        context = self._context
        self._find_origin()
        separation_m = context.settings.safety.get("separation_m", MIN_HOME_DISTANCE_M)
        found = check_all(context.roster, context.settings.vehicles, separation_m)
        context.preflight = await self._overrides.apply(check_area(context.settings) + self._advice + found)
        return context.roster.frame is not None and not any(check.blocks for check in context.preflight)

    def _find_origin(self) -> None:
        roster, origin = self._context.roster, self._context.settings.origin
        if roster.frame is not None:
            return
        if origin is None and (members := roster.members()):
            origin = members[0].state.home
        if origin is not None:
            roster.frame = LocalFrame(origin)

    def _assign_layers(self) -> None:
        context = self._context
        members, frame, flight = context.roster.members(), context.roster.local_frame(), context.settings.flight
        layers_m = altitude_layers(len(members), flight.lowest_layer_m, flight.layer_spacing_m)
        for member, layer_height_m in zip(members, layers_m, strict=True):
            if member.state.home is None:
                raise RuntimeError(f"preflight passed vehicle {member.vehicle_id} without a home")
            member.home_enu_m = frame.to_enu(member.state.home)
            member.layer_height_m = float(layer_height_m)
        homes_enu_m = np.array([member.home_enu_m for member in members])[:, :2]
        grounds_m = list(homes_enu_m)
        if context.settings.return_enu_m is not None:
            grounds_m.append(np.array(context.settings.return_enu_m))
        proposal = SafetyLimits(
            fence_enu_m=propose_fence(context.settings.area_enu_m, np.array(grounds_m), _FENCE_MARGIN_M),
            floor_m=float(min(layers_m)) - _LAYER_MARGIN_M,
            ceiling_m=float(max(layers_m)) + _LAYER_MARGIN_M,
        )
        context.flight.limits = replace(proposal, **context.settings.safety)

    def _takeoff(self, member: Member) -> Takeoff:
        if member.home_enu_m is None or member.layer_height_m is None:
            raise RuntimeError(f"vehicle {member.vehicle_id} has no altitude layer")
        return Takeoff(member.layer_height_m - float(member.home_enu_m[2]))
