"""Whether operators have suspended a mission: one state, which the coordinator sets and the search looks at."""

from __future__ import annotations

import asyncio

from aos_gcs.mission.model.phase import Suspension


class SuspensionState:
    """Present suspension of a mission, whichever plan it flies by."""

    def __init__(self) -> None:
        self._present = Suspension.NONE
        self._is_over = asyncio.Event()
        self._is_over.set()

    @property
    def present(self) -> Suspension:
        """Why no steps are made at present."""
        return self._present

    @property
    def is_on(self) -> bool:
        """Whether no further step is to be made."""
        return self._present is not Suspension.NONE

    def begin(self, suspension: Suspension) -> None:
        """Have no further step made, for this reason."""
        self._present = suspension
        self._is_over.clear()

    def end(self) -> None:
        """Have steps made again."""
        self._present = Suspension.NONE
        self._is_over.set()

    async def until_over(self) -> None:
        """Wait until steps may be made."""
        await self._is_over.wait()
