"""Hand-overs for the page: not made, only handed out."""

from __future__ import annotations

from aos_gcs.handover.model import HandoverOptions
from aos_gcs.mission.viewing import ViewerBusyError


class ScriptedHandovers:
    """Implements ``HandoverControl``; every second hand-over is refused because another one is being made."""

    PDF = b"%PDF-1.7 scripted"

    def __init__(self) -> None:
        self.asked: list[HandoverOptions] = []

    async def handover(self, options: HandoverOptions) -> bytes:
        """Hand out a file."""
        self.asked.append(options)
        if len(self.asked) % 2 == 0:
            raise ViewerBusyError("A hand-over is being made already; try again in a moment.")
        return self.PDF

    async def flight_log(self) -> str:
        """Hand out a table without flights."""
        return "operation,sortie\n"
