"""What a running mission shows on the terminal."""

from __future__ import annotations

import asyncio
import logging
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from rich.console import Console

from aos_gcs.mission.model import EventKind, MissionControl, MissionSnapshot, StepRecord

_log = logging.getLogger(__name__)


@asynccontextmanager
async def followed(mission: MissionControl) -> AsyncIterator[None]:
    """Show how a mission goes on for as long as the context is entered."""
    async with asyncio.TaskGroup() as group:
        display = group.create_task(_show(mission))
        yield
        display.cancel()


async def _show(mission: MissionControl) -> None:
    """Follow a mission until cancelled: a status line on a terminal, and one line per step."""
    console = Console(stderr=True)
    with mission.subscribe() as events, console.status("Starting.") as status:
        if not sys.stderr.isatty():
            status.stop()
        async for event in events:
            if isinstance(event.data, StepRecord):
                _log.info(_describe_step(event.data))
            elif event.kind is EventKind.SNAPSHOT and isinstance(event.data, MissionSnapshot):
                status.update(f"[bold]{event.data.phase}[/bold]  {event.data.message}")


def _describe_step(step: StepRecord) -> str:
    parts = [f"step {step.step}: visibility {step.visibility_m2:.2f} of {step.threshold_m2:.2f} m²"]
    if step.evolutionary_factor is not None:
        parts.append(f"e_f {step.evolutionary_factor:.2f} ({step.evolutionary_state})")
    if step.missing:
        parts.append(f"without {', '.join(map(str, step.missing))}")
    parts.append(f"{step.work_ms:.0f} ms of work")
    return ", ".join(parts)
