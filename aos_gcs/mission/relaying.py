"""The relay beside the handlers: reliefs are planned in every phase, and begin while the search goes on."""

from __future__ import annotations

from typing import Protocol

from aos_gcs.mission.model.phase import Phase, Suspension
from aos_gcs.mission.phases import SAMPLING
from aos_gcs.mission.sortie import Sortie
from aos_gcs.ports import Clock

_PERIOD_S = 1.0
_RELIEVES = SAMPLING | {Phase.LINE}


class Searching(Protocol):
    """The coordinator as the relay sees it."""

    @property
    def suspension(self) -> Suspension:
        """Why no steps are made at present."""
        ...

    @property
    def heading(self) -> Phase:
        """The phase that the mission is in, or changes to."""
        ...

    @property
    def sortie(self) -> Sortie:
        """The sortie by the present plan."""
        ...


async def keep_relay(mission: Searching, clock: Clock) -> None:
    """Plan and begin reliefs until cancelled."""

    def may_relieve() -> bool:
        return mission.suspension is Suspension.NONE and mission.heading in _RELIEVES

    while True:
        await mission.sortie.relay.look(may_relieve)
        await clock.sleep(_PERIOD_S)
