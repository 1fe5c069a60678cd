"""The operator's actions: what each does to the whole mission, and to single vehicles."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Protocol

from aos_gcs.errors import MissionError
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.fleet.joining import Joining
from aos_gcs.mission.fleet.return_and_land import Homing
from aos_gcs.mission.fleet.roster import Member
from aos_gcs.mission.fleet.vehicle_tasks import Errands
from aos_gcs.mission.model import Action, ActionRecord, ActionResult, Outcome, Phase, Suspension, Task
from aos_gcs.mission.phases import ENDING, ON_GROUND, check_action
from aos_gcs.mission.search.vision import Vision
from aos_gcs.ports import FlightMode, Hold, Land, ReturnToLaunch, Severity

_HOLDS = "holds its position"
_LANDS = "lands where it is"
_RETURNS = "returns to its launch point"
_RETURNS_BY_ITSELF = "returns by itself, at its autopilot's own height"
_LOST = "is lost; it cannot be reached"
_NO_MOTOR = "Aborted before any motor was started."


class Flow(Protocol):
    """What an action may do to the flow of phases."""

    suspension: Suspension

    @property
    def heading(self) -> Phase:
        """The phase that the mission is in, or on its way to by an action just taken."""
        ...

    def redirect(self, phase: Phase) -> None:
        """End the present activity and go on with ``phase``."""
        ...

    def suspend(self, suspension: Suspension) -> None:
        """Make no further step."""
        ...

    def resume(self) -> None:
        """Go on where the mission was suspended."""
        ...


class Operator:
    """Carries out actions. Every one is written to the audit log, refused ones too."""

    def __init__(
        self,
        context: MissionContext,
        errands: Errands,
        *,
        homing: Homing,
        joining: Joining,
        vision: Vision,
        flow: Flow,
    ) -> None:
        self._context = context
        self._errands = errands
        self._joining = joining
        self._homing = homing
        self._vision = vision
        self._flow = flow
        self._on_all: Mapping[Action, Callable[[], Awaitable[Sequence[ActionResult]]]] = {
            Action.START: self._start,
            Action.PAUSE: self._pause,
            Action.RESUME: self._resume,
            Action.HOLD: self._hold,
            Action.RETURN: self._return,
            Action.LAND: self._land,
            Action.ABORT: self._abort,
            Action.JOIN: self._join,
        }
        self._on_one: Mapping[Action, Callable[[Member], Awaitable[str | None]]] = {
            Action.PAUSE: self._pause_one,
            Action.RESUME: self._resume_one,
            Action.HOLD: self._hold_one,
            Action.RETURN: self._return_one,
            Action.LAND: self._land_one,
            Action.ABORT: self._return_one,
            Action.JOIN: self._joining.join,
        }

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
    ) -> tuple[ActionResult, ...]:
        """See ``MissionControl.act``."""
        context = self._context
        try:
            check_action(self._flow.heading, action, anyone_flies=bool(context.roster.airborne()))
            if action is Action.FOCUS:
                results = self._set_focus(vehicle_ids, focal_height_m)
            elif action is Action.OVERRIDE:
                raise MissionError("An override concerns one check of one vehicle; name it, and the reason.")
            elif focal_height_m is not None:
                raise MissionError(f"A focal height goes with {Action.FOCUS} only, not with {action}.")
            elif vehicle_ids is None:
                results = tuple(await self._on_all[action]())
            else:
                results = await self._act_on(action, context.roster.select(vehicle_ids))
        except MissionError as error:
            refusal = ActionRecord(
                context.clock.utc_s(), action, vehicle_ids, (), str(error), focal_height_m, operator=operator
            )
            await self._record(refusal)
            raise
        record = ActionRecord(
            context.clock.utc_s(), action, vehicle_ids, results, focal_height_m=focal_height_m, operator=operator
        )
        await self._record(record)
        return results

    async def _record(self, record: ActionRecord) -> None:
        """Write to the audit log; a disk that hangs must not keep the operator waiting for an answer."""
        async with self._context.journal.patience(f"the action {record.action}"):
            await self._context.recorder.record_action(record)

    # --- the whole mission --------------------------------------------------------------------------------------------

    async def _start(self) -> Sequence[ActionResult]:
        self._tell("start")
        self._flow.redirect(Phase.ARM)
        return self._all_members("starts")

    async def _pause(self) -> Sequence[ActionResult]:
        if self._flow.suspension is not Suspension.NONE:
            raise MissionError(f"Cannot pause: the mission is {self._flow.suspension} already.")
        self._tell("pause after this step")
        self._flow.suspend(Suspension.PAUSED)
        return self._all_members("hovers at its waypoint when this step is done")

    async def _resume(self) -> Sequence[ActionResult]:
        roster = self._context.roster
        held = roster.members(Task.HELD)
        if self._flow.suspension is Suspension.NONE and not held:
            raise MissionError("Cannot resume: nothing is paused or held.")
        self._tell("resume")
        self._flow.resume()
        results = [self._result(self._resume_one, member, "is back in the swarm") for member in held]
        if self._flow.heading not in ENDING:
            for task, act, done in (
                (Task.RETURNING, self._return_one, _RETURNS),
                (Task.LANDING, self._land_one, _LANDS),
            ):
                stopped = [member for member in roster.members(task) if isinstance(member.last_command, Hold)]
                results += [self._result(act, member, done) for member in stopped]
        return await asyncio.gather(*results)

    async def _hold(self) -> Sequence[ActionResult]:
        self._tell("hold all")
        self._errands.stop_all()
        self._joining.call_off()
        for member in self._context.roster.members(Task.JOINING):
            self._context.roster.assign(member, Task.HELD)
        if self._is_under_way():
            self._flow.suspend(Suspension.HELD)
            self._context.message = "Held: all vehicles stop where they are."
        return await self._command_airborne(lambda member: self._context.flight.command(member, Hold()), _HOLDS)

    async def _return(self) -> Sequence[ActionResult]:
        self._tell("return")
        if not self._is_under_way():
            return await self._command_airborne(self._return_one, _RETURNS_BY_ITSELF)
        return self._go_down(Phase.RETURN, _RETURNS)

    async def _land(self) -> Sequence[ActionResult]:
        self._tell("land")
        if not self._is_under_way():
            return await self._command_airborne(self._land_one, _LANDS)
        return self._go_down(Phase.LAND, _LANDS)

    async def _abort(self) -> Sequence[ActionResult]:
        self._tell("abort")
        if self._is_under_way():
            results = self._go_down(Phase.RETURN, _RETURNS)
        else:
            anyone_flies = bool(self._context.roster.airborne())
            told = {one.vehicle_id: one for one in self._all_members("stays on the ground")}
            told |= {one.vehicle_id: one for one in await self._command_airborne(self._return_one, _RETURNS_BY_ITSELF)}
            results = tuple(told.values())
            self._context.message = "Aborted: who flew returns by itself." if anyone_flies else _NO_MOTOR
            self._flow.redirect(Phase.DONE)
        self._context.outcome = Outcome.ABORTED
        return results

    async def _join(self) -> Sequence[ActionResult]:
        candidates = self._joining.candidates()
        if not candidates:
            raise MissionError("Cannot join: no vehicle that could stands on the ground.")
        return await self._act_on(Action.JOIN, candidates)

    def _set_focus(self, vehicle_ids: tuple[int, ...] | None, focal_height_m: float | None) -> tuple[ActionResult, ...]:
        if vehicle_ids is not None:
            raise MissionError("The focal plane is one for the whole mission; leave the vehicles out.")
        self._vision.override_focus(focal_height_m)
        self._tell("focus left to the program" if focal_height_m is None else f"focus at {focal_height_m:g} m")
        return ()

    def _go_down(self, phase: Phase, text: str) -> Sequence[ActionResult]:
        self._joining.call_off()
        if self._flow.heading is phase:
            self._flow.resume()
        elif self._flow.heading is Phase.LAND and self._flow.suspension is not Suspension.HELD:
            raise MissionError("Cannot return: everybody is landing; hold first.")
        else:
            self._flow.redirect(phase)
        results = [
            _result(member.vehicle_id, "is flown by its pilot" if _has_pilot(member) else None, text)
            for member in self._reachable()
        ]
        return [*results, *self._lost_results()]

    def _all_members(self, text: str) -> Sequence[ActionResult]:
        return [*(_result(member.vehicle_id, None, text) for member in self._reachable()), *self._lost_results()]

    def _lost_results(self) -> list[ActionResult]:
        """Nobody must believe that an action on all has reached them."""
        return [_result(member.vehicle_id, _LOST, "") for member in self._context.roster.members(Task.LOST)]

    async def _command_airborne(
        self, act: Callable[[Member], Awaitable[str | None]], done: str
    ) -> Sequence[ActionResult]:
        """Have all who fly do something at the same time, except those that their pilots fly."""
        airborne, lost = self._context.roster.airborne(), self._lost_results()
        results = await asyncio.gather(*(self._result(_unless_piloted(act), member, done) for member in airborne))
        return [*results, *lost]

    def _is_under_way(self) -> bool:
        """Whether the mission flies, or is about to. Else who flies has neither task nor altitude layer."""
        return self._flow.heading not in ON_GROUND

    def _reachable(self) -> list[Member]:
        return [m for m in self._context.roster.members() if m.task not in {Task.LOST, Task.LANDED}]

    # --- single vehicles ----------------------------------------------------------------------------------------------

    async def _act_on(self, action: Action, members: Sequence[Member]) -> tuple[ActionResult, ...]:
        if action not in self._on_one:
            raise MissionError(f"{action.capitalize()} concerns the whole mission; leave the vehicles out.")
        if not members:
            raise MissionError("No vehicle was named; name at least one, or none at all for the whole mission.")
        self._tell(f"{action} vehicle {', '.join(str(member.vehicle_id) for member in members)}")
        done = {
            Action.PAUSE: "stays at its waypoint",
            Action.RESUME: "is back in the swarm",
            Action.HOLD: _HOLDS,
            Action.LAND: _LANDS,
            Action.JOIN: "takes off and flies to the swarm",
        }.get(action, _RETURNS if self._is_under_way() else _RETURNS_BY_ITSELF)
        if action is Action.JOIN:
            # One after another: each takes a layer, and the column above its launch point.
            return tuple([_result(member.vehicle_id, await self._joining.join(member), done) for member in members])
        return tuple(await asyncio.gather(*(self._result(self._on_one[action], member, done) for member in members)))

    async def _result(self, act: Callable[[Member], Awaitable[str | None]], member: Member, done: str) -> ActionResult:
        if member.task is Task.LOST:
            return ActionResult(member.vehicle_id, accepted=False, text=_LOST)
        if not member.airborne:
            return ActionResult(member.vehicle_id, accepted=False, text="is not flying")
        return _result(member.vehicle_id, await act(member), done)

    async def _pause_one(self, member: Member) -> str | None:
        if member.task is not Task.SWARM:
            return f"is not in the swarm ({member.task})"
        self._context.roster.assign(member, Task.HELD)
        return None

    async def _resume_one(self, member: Member) -> str | None:
        if member.task is not Task.HELD:
            return f"is neither paused nor held ({member.task})"
        if self._flow.heading in ENDING:
            return "the mission is on its way home"
        if not member.follows_us:
            return f"does not follow us: its mode is {member.state.mode_name}"
        self._context.roster.assign(member, Task.SWARM)
        return None

    async def _hold_one(self, member: Member) -> str | None:
        self._errands.stop(member.vehicle_id)
        self._assign(member, Task.HELD)
        return await self._context.flight.command(member, Hold())

    async def _return_one(self, member: Member) -> str | None:
        if not self._is_under_way():
            return await self._context.flight.command(member, ReturnToLaunch())
        return await self._homing.send_home(member, "told by the operator")

    async def _land_one(self, member: Member) -> str | None:
        below = self._context.flight.in_the_way_down(member)
        if below is not None:
            return f"vehicle {below} flies below it, or will; hold or return it, or land all"
        self._errands.stop(member.vehicle_id)
        self._assign(member, Task.LANDING)
        return await self._context.flight.command(member, Land())

    def _assign(self, member: Member, task: Task) -> None:
        """Give a vehicle a task; who flies before the start takes part in the mission after it, like all others."""
        if self._is_under_way():
            self._context.roster.assign(member, task)

    def _tell(self, text: str) -> None:
        self._context.journal.notice(Severity.INFO, f"operator: {text}")


def _unless_piloted(act: Callable[[Member], Awaitable[str | None]]) -> Callable[[Member], Awaitable[str | None]]:
    async def checked(member: Member) -> str | None:
        return "is flown by its pilot" if _has_pilot(member) else await act(member)

    return checked


def _has_pilot(member: Member) -> bool:
    """Whether a pilot flies the vehicle: actions on all leave it alone, one on it by name does not."""
    return member.airborne and member.state.mode is FlightMode.MANUAL


def _result(vehicle_id: int, reason: str | None, done: str) -> ActionResult:
    return ActionResult(vehicle_id, accepted=reason is None, text=done if reason is None else reason)
