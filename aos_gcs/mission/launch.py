"""The launch: from the first heartbeat until all vehicles hover in their altitude layers."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.reference_surface import LEVEL
from aos_gcs.errors import MissionFailedError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.auto_start import AutoStart
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.fleet.datum import survey_ground
from aos_gcs.mission.fleet.homes import home_elsewhere, next_home, take_off_point_enu_m
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.handler_watch import sign_of_life
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.altitudes import check_altitudes
from aos_gcs.mission.preflight.ground import check_descents, check_ground
from aos_gcs.mission.preflight.inspection import Inspector
from aos_gcs.mission.preflight.overrides import Overrides
from aos_gcs.mission.preflight.plan import check_aperture, check_prior
from aos_gcs.mission.preflight.returns import check_return_climbs, return_bounds
from aos_gcs.mission.preflight.setup import check_setup, check_system_ids
from aos_gcs.mission.preflight.telemetry import check_all, check_area, check_layers, check_vehicles
from aos_gcs.mission.preflight.terrain import check_take_off_altitudes, survey_terrain
from aos_gcs.planning.descents import meetings, passes, staggered
from aos_gcs.planning.proposal import altitude_layers, propose_limits
from aos_gcs.planning.terrain.returns import ReturnClearance
from aos_gcs.ports import Arm, Disarm, Severity, Takeoff

_POLL_S = 0.5
_ARM_AGAIN_S = 2.0
_SAME_HOME_M = 1.0
"""Largest horizontal drift of a home position that leaves layers and limits as they are."""
_SAME_GROUND_M = 0.25
"""Largest vertical drift."""


class Launch:
    """The phases CONNECT to TAKEOFF. Every handler can be entered again after an interruption."""

    def __init__(
        self, context: FlightContext, overrides: Overrides, inspector: Inspector, auto_start: AutoStart
    ) -> None:
        self._context = context
        self._overrides = overrides
        self._inspector = inspector
        self._auto_start = auto_start
        self._advice = check_aperture(context.settings)
        limits = context.settings.safety.applied_to(UNLIMITED)
        self._launch_distance_m, self._separation_m = limits.launch_distance_m, limits.separation_m
        self._spares = 0
        """Vehicles for the relay that the limits in force have room for."""
        self._ground: tuple[PreflightCheck, ...] = ()
        """Checks of the ground, for the limits in force and the homes that they were made for."""
        self._terrain: tuple[PreflightCheck, ...] = ()
        """Checks of the terrain, for the same."""
        self._prior: tuple[PreflightCheck, ...] | None = None
        """Check of the prior; None before the origin is known."""
        self._clearance: ReturnClearance | None = None
        """What autopilots' own returns have to clear, for the same."""

    async def connect(self) -> Phase:
        """Wait until the vehicles that fly, or as many as are to fly, are heard."""
        context = self._context
        expected, deadlines = context.settings.vehicles, context.settings.deadlines
        deadline_s = context.clock.now_s() + deadlines.connect_s
        while len(self._heard()) < expected:
            sign_of_life()
            self._find_origin()
            heard = f"{len(self._heard())} of {expected}"
            missing = ", ".join(map(str, sorted(set(context.settings.vehicle_ids) - self._heard())))
            missing = f" Missing: {missing}." if missing else ""
            context.journal.set_message(f"Waiting for vehicles: {heard} heard.{missing}")
            if context.settings.area_enu_m and context.clock.now_s() > deadline_s:
                raise MissionFailedError(
                    f"Only {heard} vehicles were heard within {deadlines.connect_s:.0f} s; "
                    f"check that they are switched on and send to this computer's address and port.{missing}"
                )
            await context.clock.sleep(_POLL_S)
        self._choose()
        return Phase.PREFLIGHT

    def _heard(self) -> set[int]:
        """Return the ids heard: those that are to fly, or any while that is open."""
        named, heard = set(self._context.settings.vehicle_ids), {m.vehicle_id for m in self._context.roster.members()}
        return heard & named if named else heard

    def _choose(self) -> None:
        """Choose the vehicles that the settings name, none where an operator has to name them."""
        settings = self._context.settings
        is_open = not settings.vehicle_ids and not settings.any_vehicles
        self._context.roster.choose([] if is_open else sorted(self._heard())[: settings.vehicles])

    async def preflight(self) -> Phase:
        """Wait until no check of any vehicle blocks the launch."""
        context = self._context
        deadline_s = context.clock.now_s() + context.settings.deadlines.preflight_s
        while not await self._checks_pass():
            failed = [check for check in self._overrides.checks if check.blocks]
            issues = "1 blocking issue" if len(failed) == 1 else f"{len(failed)} blocking issues"
            context.journal.set_message(f"Preflight: {issues}. First: {failed[0].describe()}.")
            if self._auto_start.is_on and context.clock.now_s() > deadline_s:
                raise MissionFailedError(f"Preflight did not pass in time. {context.journal.message}")
            await context.clock.sleep(_POLL_S)
        return Phase.READY

    async def ready(self) -> Phase:
        """Wait for the operator's start, which redirects to ARM; fall back to preflight when a check fails again."""
        context = self._context
        overridden = sum(check.overridden is not None for check in self._overrides.checks)
        passed = f", {overridden} failed checks overridden" if overridden else ""
        context.journal.set_message(f"Ready to launch{passed}.")
        while await self._checks_pass():
            if self._auto_start.is_on:
                return Phase.ARM
            await context.clock.sleep(_POLL_S)
        return Phase.PREFLIGHT

    async def arm(self) -> Phase:
        """Start the motors of all vehicles; those that refuse twice stay on the ground."""
        context = self._context
        context.journal.set_message("Arming.")
        cleared = self._cleared(context.roster.chosen(Task.IDLE, Task.SWARM))
        # Entered again after a long hold, autopilots have stopped motors that were idle.
        unarmed = [member for member in cleared if not member.state.armed]
        refusals = await context.flight.command_each(unarmed, lambda _: Arm())
        refused = context.roster.select(vehicle_id for vehicle_id, refusal in refusals.items() if refusal)
        if refused:
            # A vehicle that has just missed our heartbeats for seconds, as over a bad radio, arms the second time.
            await context.clock.sleep(_ARM_AGAIN_S)
            refusals |= await context.flight.command_each(refused, lambda _: Arm())
        # Those armed before an interruption, too: their motors run.
        armed = [m for m in cleared if m.task is Task.IDLE and refusals.get(m.vehicle_id) is None]
        kept_down = await self._with_home_elsewhere(armed)
        for member in armed:
            if member not in kept_down:
                context.roster.assign(member, Task.SWARM)
        swarm = context.roster.members(Task.SWARM)
        fewest = context.settings.fewest_vehicles
        if len(swarm) < fewest:
            await context.flight.command_each(swarm, lambda _: Disarm())
            raise MissionFailedError(f"Only {len(swarm)} vehicles armed; the mission needs at least {fewest}.")
        return Phase.TAKEOFF

    async def _with_home_elsewhere(self, armed: list[Member]) -> list[Member]:
        """Return the members whose autopilots would return elsewhere than to where they stand; stop their motors."""
        context = self._context
        refusals = await asyncio.gather(*(home_elsewhere(context.clock, member) for member in armed))
        found = [(member, refusal) for member, refusal in zip(armed, refusals, strict=True) if refusal is not None]
        for member, refusal in found:
            context.journal.notice(Severity.WARNING, f"stays on the ground: {refusal.text}", member.vehicle_id)
        kept_down = [member for member, _ in found]
        await context.flight.command_each(kept_down, lambda _: Disarm())
        return kept_down

    def _cleared(self, members: list[Member]) -> list[Member]:
        """Return the members that may climb to their layers; report why the others on the ground stay there."""
        context = self._context
        barred = context.flight.vet_climbs(member for member in members if not member.airborne)
        for vehicle_id, refusal in barred.items():
            context.journal.notice(Severity.WARNING, f"stays on the ground: {refusal.text}", vehicle_id)
        return [member for member in members if member.vehicle_id not in barred]

    async def takeoff(self) -> Phase:
        """Climb vertically, each vehicle to its own layer; those that do not get there hold, outside of the swarm."""
        context = self._context
        context.journal.set_message("Climbing to the altitude layers.")
        swarm = context.roster.members(Task.SWARM)
        grounded = self._cleared([member for member in swarm if not member.airborne])
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
            context.roster.assign(member, Task.HELD)
            text = "did not reach its altitude layer: it holds, outside of the swarm. Return it"
            context.journal.notice(Severity.WARNING, text, member.vehicle_id)
        return Phase.LINE

    async def check_one(self, member: Member) -> tuple[PreflightCheck, ...]:
        """Return the checks of one vehicle as they are now, such as of one that is to join in mid-mission."""
        others = [other for other in self._chosen_or_all() if other is not member]
        own = [check for check in self._check([*others, member]) if check.vehicle_id == member.vehicle_id]
        return await self._overrides.apply(own)

    async def _checks_pass(self) -> bool:
        context = self._context
        sign_of_life()
        self._find_origin()
        self._assign_layers()
        await self._survey_terrain()
        await self._check_prior()
        if any(member.airborne for member in self._chosen_or_all()):
            self._auto_start.cancel("vehicles were found in the air")
        of_mission = check_area(context.settings) + check_vehicles(context.roster, context.settings.vehicles)
        found = await self._overrides.review(
            of_mission + self._advice + self._terrain + (self._prior or ()) + self._check(self._chosen_or_all())
        )
        return context.bounds.limits is not None and not any(check.blocks for check in found)

    def _chosen_or_all(self) -> list[Member]:
        """Return the vehicles that fly; all heard while that is open, so that an operator sees their state."""
        return self._context.roster.chosen() or self._context.roster.members()

    def _chosen_or_proposed(self) -> list[Member]:
        """Return the vehicles that fly; while that is open, the lowest ids on the ground, as many as are planned.

        Layers and limits are made for these, so that an operator reads all warnings before the confirmation. Nothing is
        written to vehicles before it.
        """
        if chosen := self._context.roster.chosen():
            return chosen
        waiting = [member for member in self._context.roster.members() if not member.state.armed]
        return waiting[: self._context.settings.vehicles]

    def _check(self, members: Sequence[Member]) -> tuple[PreflightCheck, ...]:
        """Return the matrix vehicle x check of some members as it is now."""
        settings, roster = self._context.settings, self._context.roster
        inspections = {member.vehicle_id: self._inspector.inspection(member.vehicle_id) for member in members}
        board_ids = {key: found.facts.board_id for key, found in inspections.items() if found.facts is not None}
        found = [
            *check_all(roster, members, self._launch_distance_m),
            *check_layers(roster, members, settings.flight.layer_spacing_m, self._context.bounds.limits),
            *check_altitudes(roster, members, self._separation_m, settings.flight.layer_spacing_m),
            *check_take_off_altitudes(members, roster.frame, self._context.bounds.ground),
            *check_system_ids([member.state for member in members], board_ids),
            *self._ground,
            *check_return_climbs(roster, members, self._separation_m, settings.flight.layer_spacing_m),
        ]
        for member in members:
            bounds = return_bounds(roster, member, self._clearance)
            found += check_setup(member.state, inspections[member.vehicle_id], bounds)
        return checks.in_order(found)

    def _find_origin(self) -> None:
        roster, origin = self._context.roster, self._context.settings.origin
        if roster.frame is not None:
            return
        if origin is None and (members := self._chosen_or_all()):
            origin = next_home(members[0].state)
        if origin is not None:
            roster.frame = LocalFrame(origin)

    def _assign_layers(self) -> None:
        """Give every vehicle its layer, and propose limits, as soon as all homes are known and when one has moved."""
        context = self._context
        members, roster, flight = self._chosen_or_proposed(), context.roster, context.settings.flight
        if roster.frame is None or not context.settings.area_enu_m or len(members) < context.settings.vehicles:
            return
        former = roster.ground
        roster.ground = survey_ground([member.state for member in members])
        found_enu_m = [take_off_point_enu_m(roster, member) for member in members]
        homes_enu_m = [home_enu_m for home_enu_m in found_enu_m if home_enu_m is not None]
        is_planned = self._is_planned(members, homes_enu_m) and self._spares == len(self._spare_homes_enu_m())
        if roster.ground is None or len(homes_enu_m) < len(members) or is_planned:
            roster.ground = None if former is None else former.measured_as(roster.ground)
            return
        roster.settle_altitudes()
        spare_homes_enu_m = self._spare_homes_enu_m()
        self._spares = len(spare_homes_enu_m)
        limits = propose_limits(context.settings, [*homes_enu_m, *spare_homes_enu_m])
        context.bounds.set(limits)
        # Until the ground is surveyed, layers that follow it have no heights.
        roster.layers.surface = None if context.settings.layers_follow_ground else LEVEL
        homes_m = np.array(homes_enu_m)[:, :2]
        is_past = passes(context.settings.area_enu_m, homes_m, context.flight.clearance_m(members))
        layers_m = staggered(is_past, altitude_layers(len(members), flight.lowest_layer_m, flight.layer_spacing_m))
        roster.assign_layers(members, homes_enu_m, layers_m)
        met = meetings(is_past, layers_m)
        launch_points = {member.vehicle_id: home_enu_m for member, home_enu_m in zip(members, homes_enu_m, strict=True)}
        self._ground = (
            *check_ground(launch_points, limits, context.settings),
            *check_descents([member.vehicle_id for member in members], met),
        )

    def _spare_homes_enu_m(self) -> list[NDArray[np.float64]]:
        """Return where vehicles stand, shape (3,) each, that may take off for the relay: they need layers, too."""
        frame, settings = self._context.roster.frame, self._context.settings
        is_any = settings.any_vehicles and settings.relay.enabled
        return [
            frame.to_enu(member.state.home)
            for member in self._context.roster.members(Task.IDLE)
            if frame is not None
            and member.state.home is not None
            and not member.is_chosen
            and (is_any or member.is_ready or member.vehicle_id in settings.relay.vehicle_ids)
        ]

    async def _survey_terrain(self) -> None:
        """Read the ground below the flight, once its limits are proposed, and limit the heights above it."""
        context, terrain, frame = self._context, self._context.settings.terrain, self._context.roster.frame
        limits = context.bounds.limits
        if terrain is None or frame is None or limits is None or limits.above_ground is not None:
            return
        homes_enu_m = {
            member.vehicle_id: member.home_enu_m
            for member in self._chosen_or_proposed()
            if member.home_enu_m is not None
        }
        found = await asyncio.to_thread(survey_terrain, context.settings, terrain, frame.origin, limits, homes_enu_m)
        if context.bounds.limits is limits:
            context.bounds.set(found.limits, found.ground)
            context.roster.layers.surface = found.surface
            self._terrain, self._clearance = found.checks, found.clearance

    async def _check_prior(self) -> None:
        """Read the prior, once the origin is known."""
        context, frame = self._context, self._context.roster.frame
        if self._prior is None and frame is not None and context.settings.area_enu_m:
            self._prior = await asyncio.to_thread(check_prior, context.settings, frame.origin)

    def _is_planned(self, members: list[Member], homes_enu_m: list[NDArray[np.float64]]) -> bool:
        """Return whether the layers and limits in force are those of these vehicles at these homes."""
        return self._context.bounds.limits is not None and all(
            member.home_enu_m is not None
            and member.layer_height_m is not None
            and float(np.linalg.norm((member.home_enu_m - home_enu_m)[:2])) <= _SAME_HOME_M
            and abs(float(member.home_enu_m[2] - home_enu_m[2])) <= _SAME_GROUND_M
            for member, home_enu_m in zip(members, homes_enu_m, strict=True)
        )

    def _takeoff(self, member: Member) -> Takeoff:
        if (height_m := self._context.roster.layers.above_home_m(member)) is None:
            raise RuntimeError(f"vehicle {member.vehicle_id} has no altitude layer")
        return Takeoff(height_m)
