"""Progress of a running mission on the terminal."""

from __future__ import annotations

import asyncio
import logging
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from rich.console import Console

from aos_gcs.cli.display.preflight_table import preflight_table
from aos_gcs.mission.control import MissionView
from aos_gcs.mission.model.events import EventKind
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import StepRecord

_log = logging.getLogger(__name__)

_MATRIX_PAUSE_S = 20.0
"""Shortest interval between two prints of an unfinished preflight."""


@asynccontextmanager
async def followed(mission: MissionView) -> AsyncIterator[None]:
    """Show the progress of a mission for as long as the context is entered."""
    async with asyncio.TaskGroup() as group:
        display = group.create_task(_show(mission))
        yield
        display.cancel()


async def _show(mission: MissionView) -> None:
    """Follow a mission until cancelled: a status line on a terminal, and one line per step.

    The terminal is written to in a thread: one that stands still stops the display, not the flight.
    """
    console = Console(stderr=True)
    matrix = Matrix()
    with mission.subscribe() as events, console.status("Starting.") as status:
        if not sys.stderr.isatty():
            status.stop()
        async for event in events:
            if isinstance(event.data, StepRecord):
                _log.info(_describe_step(event.data))
            elif event.kind is EventKind.SNAPSHOT and isinstance(event.data, MissionSnapshot):
                await asyncio.to_thread(status.update, f"[bold]{event.data.phase}[/bold]  {event.data.message}")
                if matrix.is_news(event.data, event.utc_s):
                    await asyncio.to_thread(
                        console.print,
                        preflight_table(event.data.preflight),
                        markup=False,
                        highlight=False,
                        soft_wrap=True,
                    )


class Matrix:
    """Decides when to print the preflight matrix: at the end of preflight, and when blocking checks have changed."""

    def __init__(self) -> None:
        self._shown: object = None
        self._due_utc_s = 0.0

    def is_news(self, snapshot: MissionSnapshot, utc_s: float) -> bool:
        """Return whether to print it now. Frequent changes while vehicles start up are delayed for some seconds."""
        if snapshot.phase is Phase.CONNECT or not snapshot.preflight:
            self._due_utc_s = utc_s + _MATRIX_PAUSE_S
            return False
        is_open = snapshot.phase is Phase.PREFLIGHT
        state = (is_open, tuple((c.vehicle_id, c.name, c.remedy) for c in snapshot.preflight if c.blocks))
        if state == self._shown or (is_open and utc_s < self._due_utc_s):
            return False
        self._shown, self._due_utc_s = state, utc_s + _MATRIX_PAUSE_S
        return True


def _describe_step(step: StepRecord) -> str:
    parts = [f"step {step.step}: visibility {step.visibility_m2:.2f} of {step.threshold_m2:.2f} m²"]
    if step.evolutionary_factor is not None:
        parts.append(f"e_f {step.evolutionary_factor:.2f} ({step.evolutionary_state})")
    if step.missing:
        parts.append(f"without {', '.join(map(str, step.missing))}")
    parts.append(f"{step.work_ms:.0f} ms of work")
    return ", ".join(parts)
