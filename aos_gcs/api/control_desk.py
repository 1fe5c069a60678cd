"""Changes of control, told to all pages and put on record."""

from __future__ import annotations

import logging
from typing import Final

from aos_gcs.api.access.operators import Access
from aos_gcs.api.access.roles import Session
from aos_gcs.api.events.hub import EventHub
from aos_gcs.errors import AosError
from aos_gcs.mission.control import MissionCommands

_log = logging.getLogger(__name__)
_HAS_IT: Final = "has control"


class ControlDesk:
    """Changes who has control.

    Args:
        access: operators, and who of them has control.
        hub: tells all pages.
        commands: puts changes on record.
    """

    def __init__(self, access: Access, hub: EventHub, commands: MissionCommands) -> None:
        self._access = access
        self._control = access.control
        self._hub = hub
        self._commands = commands

    async def claim(self, session: Session) -> None:
        """Let a command of an operator pass, if nobody else has control.

        Raises:
            NotInControlError: another operator has it; nothing may be done.
        """
        if not session.name:  # everybody is an operator, and nobody has a name
            return
        before = self._control.holder
        is_worth_telling = self._control.claim(session.name)
        if self._control.holder != before:
            await self._tell(session.name, _HAS_IT if is_worth_telling else None)

    async def ask(self, session: Session) -> None:
        """Ask for control, which is given at once where nobody who is present has it."""
        before = self._control.holder
        was_given = self._control.ask(session.name)
        if was_given and before == session.name:
            return
        await self._tell(session.name, _HAS_IT if was_given else f"asks {self._control.holder} for control")

    async def answer(self, session: Session, asking: str, *, granted: bool) -> None:
        """Give control to an operator who asks for it, or refuse; see ``Control.answer``."""
        self._control.answer(session.name, asking, granted=granted)
        await self._tell(session.name, f"{'gives control to' if granted else 'keeps control; refuses'} {asking}")

    async def take(self, session: Session, reason: str) -> None:
        """Take over control; see ``Control.take``."""
        former = self._control.take(session.name, reason)
        words = " ".join(reason.split())
        because = f": {words}" if words else ""
        await self._tell(session.name, _HAS_IT if former is None else f"takes over control from {former}{because}")

    async def release(self, session: Session) -> None:
        """Release control; see ``Control.release``."""
        self._control.release(session.name)
        await self._tell(session.name, "releases control")

    async def _tell(self, name: str, text: str | None) -> None:
        self._hub.refresh()
        await self._access.write_down()
        if text is None:
            return
        try:
            await self._commands.announce(text, operator=name)
        except AosError as error:
            _log.warning("Not on record: %s: %s (%s)", name, text, error)
