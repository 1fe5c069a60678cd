"""Control of the swarm: of several operators, one commands; the others ask for control, or take it over with a reason.

An operator who is alone notices nothing of it: whoever commands while nobody else has control, has it. Holding is no
matter of control. An operator is present while a page of theirs follows the events, and for a while after each command
of a program; control of somebody who is no longer present goes to the first who commands.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from aos_gcs.errors import AosError, InputDataError

PRESENT_FOR_S: Final = 15.0
"""Time for which an operator without a page counts as present: a page that was lost has reconnected by then."""
REQUEST_LASTS_S: Final = 60.0
MAX_REASON: Final = 200
MIN_REASON: Final = 3


class NotInControlError(AosError):
    """A command of an operator while another one has control; nothing was done."""

    def __init__(self, holder: str) -> None:
        super().__init__(f"Not done: {holder} has control. Ask for control or take it over. Hold is always possible.")


@dataclass(frozen=True, slots=True)
class ControlState:
    """Operators who are present, and who of them has control."""

    holder: str | None
    is_holder_present: bool
    operators: tuple[str, ...]
    """Operators who are present, by name."""
    requests: tuple[str, ...]
    """Operators who have asked for control, the first first."""


class Control:
    """Knows who has control. Operators are told apart by their names: one person may use several devices.

    Args:
        now_s: clock in real seconds.
        holder: operator who had control before this process began.
    """

    def __init__(self, now_s: Callable[[], float], holder: str | None = None) -> None:
        self._now_s = now_s
        self._holder = holder
        self._following: Counter[str] = Counter()
        self._seen_s: dict[str, float] = {}
        self._requests: dict[str, float] = {}
        self._awaited = holder
        """Holder of the former process, who is waited for from the first question on."""

    @property
    def holder(self) -> str | None:
        """Operator who has control, present or not."""
        return self._holder

    def state(self) -> ControlState:
        """Return who is present, who has control, and who asks for it."""
        self._forget()
        present = {name for name, count in self._following.items() if count > 0} | set(self._seen_s)
        return ControlState(
            self._holder,
            self._holder is not None and self._is_present(self._holder),
            tuple(sorted(present, key=str.casefold)),
            tuple(self._requests),
        )

    def begin_following(self, name: str) -> None:
        """Note that a page of an operator follows the events, until ``end_following``."""
        self._following[name] += 1

    def end_following(self, name: str) -> None:
        """Note that a page of an operator is gone."""
        self._following[name] -= 1
        if self._following[name] <= 0:
            del self._following[name]
        self._seen_s[name] = self._now_s()

    def leave(self, name: str) -> None:
        """Note that somebody commands no longer, whatever pages are open: control is free for the next at once."""
        self._seen_s.pop(name, None)
        self._requests.pop(name, None)

    def claim(self, name: str) -> bool:
        """Have an operator command; return whether control has changed hands by that.

        Raises:
            NotInControlError: another operator has control.
        """
        self._note(name)
        if self._holder == name:
            return False
        if self._holder is not None and self._is_present(self._holder):
            raise NotInControlError(self._holder)
        # Of an operator who is alone nothing has to be told.
        is_worth_telling = self._holder is not None or len(self.state().operators) > 1
        self._give(name)
        return is_worth_telling

    def ask(self, name: str) -> bool:
        """Ask for control; return whether it was free and has been given."""
        self._note(name)
        if self._holder is None or self._holder == name or not self._is_present(self._holder):
            self._give(name)
            return True
        self._requests[name] = self._now_s()
        return False

    def answer(self, name: str, asking: str, *, granted: bool) -> None:
        """Give control to an operator who has asked for it, or refuse.

        Raises:
            NotInControlError: another operator has control.
            InputDataError: that operator does not ask for control.
        """
        self._check_holder(name)
        if asking not in self._requests:
            raise InputDataError(f"operator: {asking} does not ask for control now.")
        del self._requests[asking]
        if granted:
            self._give(asking)

    def take(self, name: str, reason: str) -> str | None:
        """Take over control; return who had it.

        Raises:
            InputDataError: somebody else has it, and there is no reason.
        """
        self._note(name)
        former = self._holder if self._holder != name else None
        if former is not None and self._is_present(former) and len(reason.strip()) < MIN_REASON:
            raise InputDataError(f"reason: say in a few words why you take over control from {former}.")
        self._give(name)
        return former

    def release(self, name: str) -> None:
        """Release control; the first who commands has it then.

        Raises:
            NotInControlError: another operator has control.
        """
        self._check_holder(name)
        self._holder = None

    def _check_holder(self, name: str) -> None:
        self._note(name)
        self._forget()
        if self._holder is not None and self._holder != name:
            raise NotInControlError(self._holder)

    def _give(self, name: str) -> None:
        self._holder = name
        self._requests.pop(name, None)

    def _note(self, name: str) -> None:
        self._seen_s[name] = self._now_s()

    def _is_present(self, name: str) -> bool:
        if self._awaited is not None:
            self._seen_s.setdefault(self._awaited, self._now_s())
            self._awaited = None
        return self._following[name] > 0 or self._now_s() - self._seen_s.get(name, -math.inf) <= PRESENT_FOR_S

    def _forget(self) -> None:
        """Forget those who are gone, and requests that nobody has answered."""
        now_s = self._now_s()
        self._seen_s = {name: at_s for name, at_s in self._seen_s.items() if now_s - at_s <= PRESENT_FOR_S}
        self._requests = {name: at_s for name, at_s in self._requests.items() if now_s - at_s <= REQUEST_LASTS_S}
