"""Execution of a vehicle's commands."""

from __future__ import annotations

import math
from collections.abc import Callable

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Step, ask_mode, command_long
from aos_drivers.vehicle.control import Climb
from aos_drivers.vehicle.record import VehicleRecord
from aos_drivers.vehicle.transaction import Answer, CommandTransaction, result_text
from aos_drivers.vehicle.waiting import CLOCK_RESOLUTION_S, Changes
from aos_gcs.errors import CommandRefusedError, CommandTimeoutError
from aos_gcs.ports import Arm, Clock, Command, Disarm, Goto, Hold, Land, ReturnToLaunch, Takeoff

REFUSAL_GRACE_S = 0.6
"""Time after a refusal for its reason as status text, for PX4's second answer, or for the effect to show."""
_OPTIONAL_S = 2.0
"""Time for a step that the command does without."""
_SILENCE_S = 5.0
"""Real seconds: a machine that stands still for one looks like a silence of ten at ten times the speed."""
_ALWAYS_SENT = (Hold, ReturnToLaunch, Land)
_SENT_IN_FAILSAFE = (ReturnToLaunch, Land, Disarm)
"""Commands that do not cancel a failsafe of the autopilot, as PX4's is by every waypoint and hold."""
_NOT_SENT_TO_OTHERS = (Arm, Disarm, Takeoff, Goto)
"""Commands that are refused while a vehicle is flown by a pilot or another station."""
_SHOWN_BY_HEARTBEAT = frozenset({mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_COMPONENT_ARM_DISARM})

Send = Callable[[int, int, mavlink.MAVLink_message], None]
"""Sends a message to (system, component)."""


class CommandRunner:
    """Executes the commands of one vehicle. Policy: a newer command supersedes the one in progress."""

    def __init__(self, record: VehicleRecord, send: Send, changes: Changes, clock: Clock) -> None:
        self._record = record
        self._send = send
        self._changes = changes
        self._clock = clock
        self._newest: Command | None = None
        self._generation = 0

    async def run(self, command: Command, deadline_s: float) -> None:
        """See ``Vehicle.execute``."""
        self._check_vehicle(command)
        control = self._record.control
        steps = self._steps(command)
        self._newest = command
        self._generation += 1
        self._changes.announce()
        generation, takeovers = self._generation, control.takeovers

        def check() -> None:
            self._check_vehicle(command)
            if self._generation != generation:
                raise CommandRefusedError(
                    f"{type(command).__name__} for vehicle {self._record.vehicle_id} is superseded "
                    f"by {type(self._newest).__name__}"
                )
            if control.takeovers != takeovers:
                raise self._refusal(f"was taken over: {control.reason}. {type(command).__name__} is not repeated")

        if isinstance(command, Goto) and self._must_ask_mode():
            # Until then the command before it explains modes: a pilot's Hold is not taken for that of a waypoint.
            await self._run_step(ask_mode(self._record.target, self._clock.now_s()), check, deadline_s, is_last=False)
            if control.is_mode_doubtful:
                raise self._refusal(f"reports {self._record.telemetry.mode_name}, as if a pilot had chosen it")
            steps = self._steps(command)
        self._begin(command)
        for step in steps:
            await self._run_step(step, check, deadline_s, is_last=step is steps[-1])
        target = self._record.telemetry.target
        control.confirm(
            target.position if target is not None else None,
            self._clock.now_s(),
            has_target=isinstance(command, Goto | Hold),
        )

    def _steps(self, command: Command) -> list[Step]:
        record = self._record
        return record.autopilot.steps(command, record.target, record.telemetry, self._clock.now_s())

    def _must_ask_mode(self) -> bool:
        """Whether a waypoint waits for a new heartbeat, since it would have to change the mode, or may have to."""
        record = self._record
        flown_in = record.autopilot.modes_by_command.get(Goto, frozenset())
        return record.control.is_mode_outdated or record.telemetry.mode_name not in flown_in

    def _begin(self, command: Command) -> None:
        """Tell the watch of the vehicle's control which modes, and which target, are ours from now on."""
        record = self._record
        modes = record.autopilot.modes_by_command.get(type(command))
        if modes is not None:
            target = command.position if isinstance(command, Goto) else None
            climb = None
            if isinstance(command, Takeoff):
                climb = Climb(command.height_above_home_m, record.autopilot.modes_after_takeoff)
            record.control.begin(modes, target, climb)

    def _check_vehicle(self, command: Command) -> None:
        record, control = self._record, self._record.control
        if control.failsafe and not isinstance(command, _SENT_IN_FAILSAFE):
            raise self._refusal(f"is in a failsafe ({control.failsafe}): only return and land are sent to it")
        if isinstance(command, _ALWAYS_SENT):
            return
        if record.is_ambiguous(self._clock.now_s()):
            raise CommandRefusedError(f"two vehicles use system id {record.vehicle_id}: change the id of one of them")
        if control.reason and isinstance(command, _NOT_SENT_TO_OTHERS):
            raise self._refusal(f"was taken over: {control.reason}. Resume it first")
        heard_at_s = record.heard_at_s if record.heard_at_s is not None else -math.inf
        silence_s = (self._clock.now_s() - heard_at_s) / self._clock.speed
        if silence_s > _SILENCE_S:
            raise CommandRefusedError(
                f"vehicle {record.vehicle_id} has been silent for {silence_s:.0f} s: "
                "only hold, return and land are sent to it"
            )

    def _refusal(self, reason: str) -> CommandRefusedError:
        return CommandRefusedError(f"vehicle {self._record.vehicle_id} {reason}")

    async def _run_step(self, step: Step, check: Callable[[], None], deadline_s: float, *, is_last: bool) -> None:
        """Send one step until it is done; ``check`` raises when it must not go on."""
        record = self._record
        started_s = self._clock.now_s()
        if step.is_optional:
            deadline_s = min(deadline_s, started_s + _OPTIONAL_S)
        transaction = CommandTransaction(step.message, step.repeat_s, ignored_results=step.ignored_results)
        needs_acceptance = step.needs_acceptance or step.is_done(record.telemetry, started_s)

        def is_done() -> bool:
            check()
            if is_last and transaction.answer is not Answer.NONE:
                record.control.take_answer(self._clock.now_s(), is_accepted=transaction.answer is Answer.ACCEPTED)
            is_shown = step.is_done(record.telemetry, self._clock.now_s())
            is_ignored = transaction.result in step.ignored_results and not needs_acceptance
            needs_answer = needs_acceptance or step.needs_answer
            return is_shown and (transaction.answer is Answer.ACCEPTED or is_ignored or not needs_answer)

        awaits_heartbeat = step.message.command in _SHOWN_BY_HEARTBEAT

        def is_decided() -> bool:
            is_unseen = awaits_heartbeat and transaction.answer is Answer.ACCEPTED
            return is_done() or is_unseen or transaction.answer is Answer.REFUSED

        record.transactions[transaction] = None
        try:
            while not is_done():
                if awaits_heartbeat and transaction.answer is Answer.ACCEPTED:
                    awaits_heartbeat = False
                    self._ask_for_heartbeat()
                if step.is_optional and (transaction.answer is Answer.REFUSED or self._clock.now_s() >= deadline_s):
                    return
                if transaction.answer is Answer.REFUSED:
                    await self._confirm_refusal(step, transaction, is_done, started_s, deadline_s)
                    continue
                now_s = self._clock.now_s() + CLOCK_RESOLUTION_S
                if now_s >= deadline_s:
                    raise self._timeout(step, transaction, started_s)
                message = transaction.poll(now_s)
                if message is not None:
                    self._send(record.vehicle_id, record.target.component_id, message)
                await self._changes.wait_for(is_decided, min(deadline_s, transaction.due_s))
        finally:
            record.transactions.pop(transaction)

    def _ask_for_heartbeat(self) -> None:
        """Request the vehicle's mode now; unrequested heartbeats come once a second."""
        target = self._record.target
        request = command_long(target, mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_HEARTBEAT)
        self._send(target.system_id, target.component_id, request)

    async def _confirm_refusal(
        self,
        step: Step,
        transaction: CommandTransaction,
        is_done: Callable[[], bool],
        started_s: float,
        deadline_s: float,
    ) -> None:
        """Raise the refusal, unless a second answer or telemetry shows that the vehicle obeys after all."""
        until_s = min(deadline_s, self._clock.now_s() + REFUSAL_GRACE_S)
        if await self._changes.wait_for(lambda: transaction.answer is Answer.ACCEPTED or is_done(), until_s):
            return
        reason = self._text_since(started_s) or result_text(transaction.result)
        raise CommandRefusedError(f"vehicle {self._record.vehicle_id} refuses to {step.name}: {reason}")

    def _timeout(self, step: Step, transaction: CommandTransaction, started_s: float) -> CommandTimeoutError:
        is_answered = transaction.answer is Answer.ACCEPTED
        command = f"the command to {step.name}"
        no_effect = f"accepted {command}, but telemetry does not show it"
        problem = no_effect if is_answered else f"did not acknowledge {command}"
        text = self._text_since(started_s)
        reason = f" ({text})" if text else ""
        return CommandTimeoutError(f"vehicle {self._record.vehicle_id} {problem}{reason}: check link and vehicle")

    def _text_since(self, started_s: float) -> str:
        telemetry = self._record.telemetry
        is_new = telemetry.text_at_s is not None and telemetry.text_at_s >= started_s
        return telemetry.text if is_new else ""
