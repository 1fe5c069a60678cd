"""Order of operators' commands: one that arrives late, or was overtaken by a newer one, is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import ACTION_NAMES, Action, Seen

MAX_AGE_S: Final = 2.0
"""Default age, in real seconds, of the state that an operator saw when giving a command."""
_REMEDY: Final = "Check the vehicles, then send it again."


class OutdatedError(MissionError):
    """A command that was given on the basis of a state that no longer holds; nothing was done."""


@dataclass(frozen=True, slots=True)
class _Taken:
    number: int
    what: str
    operator: str


_NONE: Final = _Taken(0, "", "")


class CommandOrder:
    """Numbers the commands that are carried out, and refuses those that are out of date.

    A network that stalls delivers commands when nobody expects them any more: to vehicles that others have commanded
    since. Only a hold is never refused, and what is older than a hold never undoes it.

    Args:
        mission_id: identifier of the mission.
        now_s: real seconds of a clock that all processes of this machine share, such as that of the event loop.
        max_age_s: oldest state, in real seconds, by which an operator may command.
    """

    def __init__(self, mission_id: str, now_s: Callable[[], float], max_age_s: float = MAX_AGE_S) -> None:
        self._mission_id = mission_id
        self._now_s = now_s
        self._max_age_s = max_age_s
        self._latest_on_all = _NONE
        self._latest_on: dict[int, _Taken] = {}
        self.count = 0
        """Number of the latest command that was carried out."""

    def check(self, seen: Seen | None, action: Action, vehicle_ids: tuple[int, ...] | None = None) -> None:
        """Raise ``OutdatedError`` with the reason for a command that is out of date.

        Args:
            seen: state by which it was given; None for commands that come from the program itself.
            action: requested action.
            vehicle_ids: vehicles concerned; None for all.
        """
        if action is Action.HOLD:
            return
        self.check_age(seen)
        if action is not Action.FOCUS:
            self.check_overtaken(seen, vehicle_ids)

    def check_overtaken(self, seen: Seen | None, vehicle_ids: tuple[int, ...] | None) -> None:
        """Raise ``OutdatedError`` if any of these vehicles, None for all, was commanded after that state."""
        if seen is None:
            return
        newest = self._newest(vehicle_ids)
        if newest.number > seen.command_count:
            raise OutdatedError(f"Not done: {newest.operator or 'an operator'} sent {newest.what} meanwhile. {_REMEDY}")

    def check_age(self, seen: Seen | None) -> None:
        """Raise ``OutdatedError`` for a command by a state that is too old, or of another mission."""
        if seen is None:
            return
        if seen.mission_id != self._mission_id:
            raise OutdatedError(f"Not done: the command was meant for the mission {seen.mission_id}. {_REMEDY}")
        age_s = abs(self._now_s() - seen.at_s)
        if age_s > self._max_age_s:
            raise OutdatedError(
                f"Not done: the command arrived with data that were {age_s:.1f} s old, more than "
                f"{self._max_age_s:g} s. {_REMEDY}"
            )

    def note(self, action: Action | str, vehicle_ids: tuple[int, ...] | None, operator: str) -> None:
        """Count a command that is carried out now: an action, or another one in words."""
        if action == Action.FOCUS:
            return
        self.count += 1
        taken = _Taken(self.count, ACTION_NAMES[action] if isinstance(action, Action) else action, operator)
        if vehicle_ids is None:
            self._latest_on_all = taken
        else:
            self._latest_on.update(dict.fromkeys(vehicle_ids, taken))

    def _newest(self, vehicle_ids: tuple[int, ...] | None) -> _Taken:
        """Return the latest command that concerned any of these vehicles."""
        among = list(self._latest_on.values()) if vehicle_ids is None else [self._of(one) for one in vehicle_ids]
        return max([self._latest_on_all, *among], key=_number)

    def _of(self, vehicle_id: int) -> _Taken:
        return self._latest_on.get(vehicle_id, _NONE)


def _number(taken: _Taken) -> int:
    return taken.number
