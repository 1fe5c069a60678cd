"""The operators' actions: what each does to the whole mission, and to single vehicles."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import replace

from aos_gcs.errors import MissionError
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.landing.descents import refuse_landing
from aos_gcs.mission.fleet.member import Member
from aos_gcs.mission.fleet.reinforcements.joining import Order
from aos_gcs.mission.fleet.standing_hold import NONE_HELD, StandingHold
from aos_gcs.mission.fleet.vehicle_tasks import VehicleTasks
from aos_gcs.mission.flow import Flow
from aos_gcs.mission.model.actions import ACTION_NAMES, Action, ActionRecord, ActionResult, Refusal, Seen
from aos_gcs.mission.model.phase import Phase, Suspension
from aos_gcs.mission.model.vehicles import TASK_NAMES, Task
from aos_gcs.mission.phases import ACTIONS, BEFORE_START, ENDING, ON_GROUND, check_action
from aos_gcs.mission.resuming import check_resume, doubtful_position, not_ours
from aos_gcs.mission.vehicle_actions import PILOTED, VehicleAction, result, unless_piloted, unless_taken_over
from aos_gcs.ports import Hold, Land, ReturnToLaunch

_HOLDS = "holds its position"
_LANDS = "lands where it is"
_RETURNS = "returns to its launch point"
_RETURNS_BY_AUTOPILOT = "returns by its autopilot, at the autopilot's own height"
_LOST = Refusal("link lost: it cannot be reached")
_NOT_FLYING = Refusal("is not flying")
_CONFIRMATIONS = frozenset({Action.READY, Action.NOT_READY})
_MOVE_NONE = _CONFIRMATIONS | {Action.HOLD, Action.FOCUS, Action.OVERRIDE, Action.CHOOSE}
"""Actions that a hold of all outlasts."""


class ActionHandler:
    """Carries out operators' actions and writes every one to the audit log, refused ones too.

    Args:
        context: context of the mission.
        vehicle_tasks: runs the procedures of single vehicles.
        flow: order of the phases.
        standing_hold: takes holds of all for vehicles that are found later.
    """

    def __init__(
        self, context: MissionContext, vehicle_tasks: VehicleTasks, flow: Flow, standing_hold: StandingHold
    ) -> None:
        self._context = context
        self._standing_hold = standing_hold
        self._vehicle_tasks = vehicle_tasks
        self._flow = flow
        self._on_all: Mapping[Action, Callable[[str], Awaitable[Sequence[ActionResult]]]] = {
            Action.START: self._start,
            Action.PAUSE: self._pause,
            Action.RESUME: self._resume,
            Action.HOLD: self._hold,
            Action.RETURN: self._return,
            Action.LAND: self._land,
            Action.ABORT: self._abort,
            Action.JOIN: self._join,
            Action.NEW_SORTIE: self._new_sortie,
            Action.READY: self._confirm_all,
            Action.NOT_READY: self._confirm_all,
        }
        self._on_one: Mapping[Action, VehicleAction] = {
            Action.PAUSE: self._pause_one,
            Action.RESUME: self._resume_one,
            Action.HOLD: self._hold_one,
            Action.RETURN: self._return_one,
            Action.LAND: self._land_one,
            Action.ABORT: self._return_one,
        }

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
        seen: Seen | None = None,
    ) -> tuple[ActionResult, ...]:
        """Carry out an action; see ``MissionCommands.act``."""
        roster, utc_s = self._context.roster, self._context.clock.utc_s
        try:
            self._context.order.check(seen, action, vehicle_ids)
            if self._flow.heading in BEFORE_START:
                self._context.auto_start.cancel(f"{operator or 'an operator'} has acted")
            check_action(self._flow.heading, action, anyone_flies=bool(roster.commandable()))
            self._context.order.note(action, vehicle_ids, operator)
            if action not in _MOVE_NONE:
                self._standing_hold.end()
            if action is Action.FOCUS:
                results = self._set_focus(vehicle_ids, focal_height_m, operator)
            elif action is Action.OVERRIDE:
                raise MissionError("An override concerns one check of one vehicle; name it, and the reason.")
            elif focal_height_m is not None:
                raise MissionError(f"Cannot {ACTION_NAMES[action]} with a focal height; leave the height out.")
            elif action is Action.CHOOSE:
                results = self._choose(vehicle_ids or (), operator)
            elif vehicle_ids is None:
                results = tuple(await self._on_all[action](operator))
            else:
                results = await self._act_on(action, roster.select(vehicle_ids), operator)
        except MissionError as error:
            await self._record(
                ActionRecord(utc_s(), action, vehicle_ids, (), str(error), focal_height_m, operator=operator)
            )
            raise
        await self._record(
            ActionRecord(utc_s(), action, vehicle_ids, results, focal_height_m=focal_height_m, operator=operator)
        )
        return results

    async def _record(self, record: ActionRecord) -> None:
        """Write to the audit log; a disk that hangs must not keep the operator waiting for an answer."""
        async with self._context.journal.with_disk_timeout(f"the action {record.action}"):
            await self._context.recorder.record_action(record)

    @property
    def _flight(self) -> FlightControl:
        return self._flow.sortie.context.flight

    # --- the whole mission --------------------------------------------------------------------------------------------

    def _choose(self, vehicle_ids: tuple[int, ...], operator: str) -> tuple[ActionResult, ...]:
        """Have the mission fly with these vehicles and no others; connecting and preflight start anew."""
        if not (members := self._context.roster.select(vehicle_ids)):
            raise MissionError("A mission needs at least one vehicle; name it.")
        chosen = tuple(sorted(member.vehicle_id for member in members))
        settings = self._flow.sortie.context.settings
        self._flow.follow_plan(replace(settings, vehicles=len(chosen), vehicle_ids=chosen))
        self._announce(operator, f"vehicles {', '.join(map(str, chosen))} fly the mission")
        return tuple(result(vehicle_id, None, "flies the mission") for vehicle_id in chosen)

    async def _start(self, operator: str) -> Sequence[ActionResult]:
        self._announce(operator, "start")
        self._flow.redirect(Phase.ARM)
        return self._all_members("starts")

    async def _pause(self, operator: str) -> Sequence[ActionResult]:
        if self._flow.suspension is not Suspension.NONE:
            raise MissionError(f"Cannot pause: the mission is {self._flow.suspension} already.")
        self._announce(operator, "pause after this step")
        self._flow.suspend(Suspension.PAUSED)
        return self._all_members("hovers at its waypoint after this step")

    async def _resume(self, operator: str) -> Sequence[ActionResult]:
        roster = self._context.roster
        held = roster.members(Task.HELD)
        if self._flow.suspension is Suspension.NONE and not held:
            raise MissionError("Cannot resume: nothing is paused or held.")
        if self._flow.suspension is not Suspension.NONE and self._flow.heading not in {Phase.ARM, *ENDING}:
            check_resume(roster, self._flow.sortie.context.settings.fewest_vehicles)
        self._announce(operator, "resume")
        self._flow.resume()
        resume = unless_taken_over(self._resume_one)
        results = [self._result(resume, member, self._resumed_text) for member in held]
        if self._flow.heading not in ENDING:
            for task, act, done in (
                (Task.RETURNING, self._return_one, _RETURNS),
                (Task.LANDING, self._land_one, _LANDS),
            ):
                stopped = [member for member in roster.members(task) if isinstance(member.last_command, Hold)]
                results += [self._result(unless_piloted(act), member, done) for member in stopped]
        return await asyncio.gather(*results)

    async def _hold(self, operator: str) -> Sequence[ActionResult]:
        self._announce(operator, "hold all")
        self._vehicle_tasks.stop_all()
        self._flow.sortie.joining.call_off()
        for member in self._context.roster.members(Task.JOINING):
            self._context.roster.assign(member, Task.HELD)
        if self._is_under_way():
            self._flow.suspend(Suspension.HELD)
            self._context.journal.set_message("Held: all vehicles stop where they are.")
        results = await self._command_airborne(lambda member: self._flight.command(member, Hold()), _HOLDS)
        self._standing_hold.begin(self._context.clock.now_s(), (result.vehicle_id for result in results))
        if not results and not self._is_under_way():
            raise MissionError(NONE_HELD)
        return results

    async def _return(self, operator: str) -> Sequence[ActionResult]:
        self._announce(operator, "return all")
        if not self._is_under_way():
            return await self._command_airborne(self._return_one, _RETURNS_BY_AUTOPILOT)
        return await self._go_down(Phase.RETURN, _RETURNS)

    async def _land(self, operator: str) -> Sequence[ActionResult]:
        self._announce(operator, "land all")
        if not self._is_under_way():
            return await self._command_airborne(self._land_one, _LANDS)
        return await self._go_down(Phase.LAND, _LANDS)

    async def _abort(self, operator: str) -> Sequence[ActionResult]:
        self._announce(operator, "abort")
        if self._is_under_way():
            results = await self._go_down(Phase.RETURN, _RETURNS)
        else:
            is_anyone_airborne = bool(self._context.roster.commandable())
            told = {one.vehicle_id: one for one in self._all_members("stays on the ground")}
            told |= {
                one.vehicle_id: one for one in await self._command_airborne(self._return_one, _RETURNS_BY_AUTOPILOT)
            }
            results = tuple(told.values())
            self._context.journal.set_message(
                "Aborted: airborne vehicles return on their own."
                if is_anyone_airborne
                else "Aborted before any motor was started."
            )
            self._flow.redirect(Phase.DONE)
        self._flow.abort()
        return results

    async def _join(self, operator: str) -> Sequence[ActionResult]:
        candidates = self._flow.sortie.joining.candidates()
        if not candidates:
            raise MissionError("Cannot join: no vehicle of this mission is on the ground. Name another one.")
        return await self._act_on(Action.JOIN, candidates, operator)

    async def _confirm_all(self, operator: str) -> Sequence[ActionResult]:  # noqa: ARG002
        raise MissionError("Name the vehicles that are ready, or are not: each is confirmed on its own.")

    async def _new_sortie(self, operator: str) -> Sequence[ActionResult]:
        self._announce(operator, "new sortie")
        self._flow.begin_new_sortie()
        return ()

    def _set_focus(
        self, vehicle_ids: tuple[int, ...] | None, focal_height_m: float | None, operator: str
    ) -> tuple[ActionResult, ...]:
        if vehicle_ids is not None:
            raise MissionError("The whole mission has one focal plane; leave the vehicles out.")
        self._flow.sortie.vision.override_focus(focal_height_m)
        self._announce(operator, "automatic focus" if focal_height_m is None else f"focus at {focal_height_m:g} m")
        return ()

    async def _go_down(self, phase: Phase, text: str) -> Sequence[ActionResult]:
        self._flow.sortie.joining.call_off()
        left = self._flow.sortie.return_and_land.left_alone() if self._flow.heading is phase else []
        if phase is Phase.LAND:
            self._flow.sortie.return_and_land.land_here()
        if self._flow.heading is phase:
            self._flow.resume()
        elif self._flow.heading is Phase.LAND and self._flow.suspension is not Suspension.HELD:
            raise MissionError("Cannot return: all vehicles are landing. Hold them first.")
        else:
            self._flow.redirect(phase)
        refusals = {member.vehicle_id: await self._go_on_down(member) for member in left}
        results = [
            result(one.vehicle_id, PILOTED if one.has_pilot else refusals.get(one.vehicle_id), text)
            for one in self._reachable()
        ]
        return [*results, *self._lost_results()]

    def _all_members(self, text: str) -> Sequence[ActionResult]:
        return [*(result(member.vehicle_id, None, text) for member in self._reachable()), *self._lost_results()]

    def _lost_results(self) -> list[ActionResult]:
        """Return the lost vehicles as refused: an action on all has not reached them."""
        lost = self._context.roster.members(Task.LOST)
        return [result(member.vehicle_id, _LOST, "") for member in lost if not member.is_reachable]

    async def _command_airborne(self, act: VehicleAction, done: str) -> Sequence[ActionResult]:
        """Have all airborne vehicles do something at the same time, except those that a pilot flies."""
        members, lost = self._context.roster.commandable(), self._lost_results()
        results = await asyncio.gather(*(self._result(unless_piloted(act), member, done) for member in members))
        return [*results, *lost]

    def _is_under_way(self) -> bool:
        """Return whether the mission flies, or is about to; before and after, no vehicle has a task or a layer."""
        return self._flow.heading not in ON_GROUND

    def _reachable(self) -> list[Member]:
        """Return the vehicles of the mission that are heard, but for those that prove that they have landed."""
        members = [m for m in self._context.roster.members() if m.takes_part and m.is_reachable]
        return [m for m in members if m.task is not Task.LANDED or m.airborne]

    # --- single vehicles ----------------------------------------------------------------------------------------------

    async def _act_on(self, action: Action, members: Sequence[Member], operator: str) -> tuple[ActionResult, ...]:
        if action not in self._on_one and action is not Action.JOIN and action not in _CONFIRMATIONS:
            raise MissionError(
                f"Cannot {ACTION_NAMES[action]} for single vehicles: this concerns the whole mission; "
                "leave the vehicles out."
            )
        if not members:
            raise MissionError("No vehicle was named; name at least one, or none at all for the whole mission.")
        named = ", ".join(str(member.vehicle_id) for member in members)
        if action in _CONFIRMATIONS:
            return self._confirm(action is Action.READY, members, operator, named)
        self._announce(operator, f"{action} vehicle {named}")
        done = {
            Action.PAUSE: "hovers, outside of the swarm",
            Action.RESUME: self._resumed_text,
            Action.HOLD: _HOLDS,
            Action.LAND: _LANDS,
            Action.JOIN: "takes off and flies to the swarm",
        }.get(action, _RETURNS if self._is_under_way() else _RETURNS_BY_AUTOPILOT)
        if action is Action.JOIN:
            # One after another: each takes a layer, and the column above its launch point.
            join, order = self._flow.sortie.joining.join, self._join_order()
            return tuple([result(member.vehicle_id, await join(member, order), done) for member in members])
        return tuple(await asyncio.gather(*(self._result(self._on_one[action], member, done) for member in members)))

    def _join_order(self) -> Order:
        """Return the order to join given now: no vehicle starts by it any more in another phase, or once all hold."""
        flow, was_held = self._flow, self._flow.suspension is Suspension.HELD
        return flow.sortie.joining.order(
            lambda: flow.heading in ACTIONS[Action.JOIN] and (was_held or flow.suspension is not Suspension.HELD)
        )

    def _confirm(
        self, is_ready: bool, members: Sequence[Member], operator: str, named: str
    ) -> tuple[ActionResult, ...]:
        """Confirm vehicles on the ground for the relay, or take that back."""
        self._announce(operator, f"vehicle {named} {'is' if is_ready else 'is not'} ready to relieve others")
        done = "may take off once, to relieve another vehicle" if is_ready else "stays on the ground"
        confirm = self._flow.sortie.relay.confirm
        return tuple(result(one.vehicle_id, confirm(one, is_ready=is_ready), done) for one in members)

    async def _result(self, act: VehicleAction, member: Member, done: str) -> ActionResult:
        if not member.is_reachable:
            return result(member.vehicle_id, _LOST, done)
        if not self._context.roster.may_fly(member):
            return result(member.vehicle_id, _NOT_FLYING, done)
        return result(member.vehicle_id, await act(member), done)

    async def _pause_one(self, member: Member) -> Refusal | None:
        if member.task is not Task.SWARM:
            return Refusal(f"is not in the swarm ({TASK_NAMES[member.task]})")
        self._context.roster.assign(member, Task.HELD)
        # A waypoint of a sweep is far away.
        return await self._flight.command(member, Hold()) if self._flow.sortie.search.flies_on else None

    async def _resume_one(self, member: Member) -> Refusal | None:
        if member.task is not Task.HELD:
            return Refusal(f"is neither paused nor held ({TASK_NAMES[member.task]})")
        if not member.follows_us_once_reclaimed:
            return not_ours(member)
        if (refusal := doubtful_position(member)) is not None:
            return refusal
        member.vehicle.reclaim()
        if self._flow.heading in ENDING:
            return await self._go_on_down(member)
        self._context.roster.assign(member, Task.SWARM)
        return None

    @property
    def _resumed_text(self) -> str:
        if self._flow.heading not in ENDING:
            return "is back in the swarm"
        return _RETURNS if self._goes_home else _LANDS

    @property
    def _goes_home(self) -> bool:
        return self._flow.heading is Phase.RETURN or self._flow.sortie.return_and_land.goes_home

    async def _go_on_down(self, member: Member) -> Refusal | None:
        return await (self._return_one(member) if self._goes_home else self._land_one(member))

    async def _hold_one(self, member: Member) -> Refusal | None:
        self._vehicle_tasks.stop(member.vehicle_id)
        self._assign(member, Task.HELD)
        return await self._flight.command(member, Hold())

    async def _return_one(self, member: Member) -> Refusal | None:
        if not self._is_under_way():
            self._vehicle_tasks.stop(member.vehicle_id)
            return await self._flight.command(member, ReturnToLaunch())
        return await self._flow.sortie.return_and_land.send_home(member, "ordered by the operator")

    async def _land_one(self, member: Member) -> Refusal | None:
        if (refusal := refuse_landing(self._flow.sortie.context, member)) is not None:
            return refusal
        self._vehicle_tasks.stop(member.vehicle_id)
        self._assign(member, Task.LANDING)
        return await self._flight.command(member, Land())

    def _assign(self, member: Member, task: Task) -> None:
        """Give a vehicle a task; before the start none has one, so that all take part in the mission after it."""
        if self._is_under_way():
            self._context.roster.assign(member, task)

    def _announce(self, operator: str, text: str) -> None:
        self._context.journal.operator_notice(operator, text)
