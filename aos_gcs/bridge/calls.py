"""Commands that come from the interface, carried out beside each other."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Any, Final

from aos_gcs import errors
from aos_gcs.errors import AosError, MissionError
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.command_order import OutdatedError
from aos_gcs.mission.control import MissionCommands
from aos_gcs.mission.model.actions import Action, Seen
from aos_gcs.mission.model.findings import FindingChange
from aos_gcs.mission.model.proposals import ProposalUse
from aos_gcs.planning.plan import MissionPlan

_log = logging.getLogger(__name__)

MAX_CALLS: Final = 32
"""Commands that may be in progress; a hold is taken beyond that."""
BUSY: Final = "Not done: too many commands are in progress. Check the vehicles, then send it again."
ERRORS: Final[dict[str, type[AosError]]] = {
    kind.__name__: kind
    for kind in (
        OutdatedError,
        MissionError,
        errors.CommandError,
        errors.LinkError,
        errors.InputDataError,
        errors.ConfigurationError,
        AosError,
    )
}
"""Errors that are told by their names; others as the nearest of these."""


class MissionCalls:
    """Carries out commands, and answers each of them.

    Args:
        commands: commands to the mission.
        answer: takes the name and the values of an answer.
    """

    def __init__(self, commands: MissionCommands, answer: Callable[..., None]) -> None:
        self._commands = commands
        self._answer = answer
        self._running: set[asyncio.Task[None]] = set()

    def begin(self, name: str, number: int, *values: Any) -> None:
        """Begin a command of the table of requests."""
        if len(self._running) >= MAX_CALLS and not (name == "act" and values[0] is Action.HOLD):
            self._answer("refused", number, MissionError.__name__, BUSY)
            return
        # It outlives the interface: a command that vehicles carry out is followed to its end.
        task = asyncio.create_task(self._call(name, number, values))
        self._running.add(task)
        task.add_done_callback(self._running.discard)

    async def _call(self, name: str, number: int, values: tuple[Any, ...]) -> None:
        try:
            result = await getattr(self, f"_{name}")(*values)
        except AosError as error:
            kind = next(one.__name__ for one in type(error).__mro__ if one.__name__ in ERRORS)
            self._answer("refused", number, kind, str(error))
        except Exception:
            _log.exception("A command of the dashboard has failed: %s", name)
            text = "The station could not do this because of an error of its own; its log has the details."
            self._answer("refused", number, AosError.__name__, text)
        else:
            self._answer(f"done {name}", number, result)

    async def _act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None,
        operator: str,
        seen: Seen | None,
    ) -> object:
        return await self._commands.act(action, vehicle_ids, focal_height_m, operator=operator, seen=seen)

    async def _override_check(
        self, vehicle_id: int, check: str, reason: str | None, operator: str, seen: Seen | None
    ) -> object:
        return await self._commands.override_check(vehicle_id, check, reason, operator=operator, seen=seen)

    async def _acknowledge(self, notice_ids: tuple[int, ...], operator: str) -> None:
        await self._commands.acknowledge(notice_ids, operator=operator)

    async def _announce(self, text: str, operator: str) -> None:
        await self._commands.announce(text, operator=operator)

    async def _add_finding(self, position_enu_m: EnuPoint, comment: str, operator: str) -> object:
        return await self._commands.add_finding(position_enu_m, comment, operator=operator)

    async def _change_finding(self, finding_id: int, change: FindingChange, operator: str) -> object:
        return await self._commands.change_finding(finding_id, change, operator=operator)

    async def _decide_proposal(self, proposal_id: int, use: ProposalUse, operator: str) -> object:
        return await self._commands.decide_proposal(proposal_id, use, operator=operator)

    async def _apply_plan(self, plan: MissionPlan, operator: str, seen: Seen | None) -> None:
        await self._commands.apply_plan(plan, operator=operator, seen=seen)
