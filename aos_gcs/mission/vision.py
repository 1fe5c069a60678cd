"""What the swarm sees: from the frames of a step to their analysis."""

from __future__ import annotations

import asyncio

from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.imaging.step import analyse_step
from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.sampling import Sample, to_frame


class Vision:
    """Turns the frames of each step into what is known from them."""

    def __init__(self, context: MissionContext) -> None:
        self._context = context

    async def see(self, step: int, taken: Sample) -> StepAnalysis:
        """Analyse the frames; they are written to the disk meanwhile."""
        context = self._context
        frames = [to_frame(capture, context.roster.local_frame()) for capture in taken.captures]
        async with context.journal.patience(f"frames of step {step}"):
            for capture in taken.captures:
                await context.recorder.record_frame(step, capture)
        return await asyncio.to_thread(analyse_step, frames, context.settings.imaging)
