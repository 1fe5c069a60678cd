"""The end of a search for a wanted probability of detection: when it is reached, and gaps that are flown again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.ground.mapping import GroundMapping
from aos_gcs.mission.search.scan.progress import ScanProgress
from aos_gcs.planning.plan import plan_of
from aos_gcs.ports import Severity

_LEAST_SHARE = 0.25
"""Share of the expected gain that a round of gaps must have brought for another one to be flown."""


class GapFlights:
    """Ends a search when the wanted probability of detection is reached, and goes on with gaps until then.

    Args:
        context: context of the flight.
        ground: map of the searched ground.
        progress: legs of the scan.
    """

    def __init__(self, context: FlightContext, ground: GroundMapping, progress: ScanProgress) -> None:
        self._context = context
        self._ground = ground
        self._progress = progress
        self._expected: tuple[float, float] | None = None
        """Probability of detection before the latest round of gaps, and that expected after it."""

    @property
    def is_enough(self) -> bool:
        """Whether the wanted probability of detection is reached; says so."""
        pod, reached = self._context.settings.search.pod, self._reached
        if pod is None or reached is None or reached < pod:
            return False
        text = (
            f"Probability of detection {reached:.0%} reached ({pod:.0%} wanted): the legs that are left are not flown"
        )
        self._context.journal.notice(Severity.NEWS, text)
        return True

    @property
    def _reached(self) -> float | None:
        figures = self._ground.figures
        return None if figures is None or figures.detection is None else figures.detection.standing

    async def after(self, following: Phase, vehicles: int, middle_m: NDArray[np.float64]) -> Phase:
        """Return the phase after a step: instead of the return behind the last leg, gaps are flown again.

        Args:
            following: phase that the step has led to.
            vehicles: vehicles of the swarm.
            middle_m: horizontal place of the swarm's middle, shape (2,).
        """
        settings = self._context.settings
        if following is not Phase.RETURN or not self._progress.is_over or settings.search.pod is None:
            return following
        sign_of_life(WORK_S)
        left_s = settings.deadlines.search_s - self._context.journal.elapsed_s()
        plan = replace(plan_of(settings), vehicles=vehicles)
        found = await self._ground.find_gaps(plan, (float(middle_m[0]), float(middle_m[1])), left_s)
        if found is None or not found.legs:
            return following
        if self._expected is not None:
            before, expected = self._expected
            if found.detection_before - before < _LEAST_SHARE * (expected - before):
                text = "Flying gaps again has gained little of what was expected: the search ends"
                self._context.journal.notice(Severity.WARNING, text)
                return following
        self._expected = (found.detection_before, found.detection_after)
        count = "1 stretch is" if len(found.legs) == 1 else f"{len(found.legs)} stretches are"
        self._context.journal.notice(
            Severity.NEWS,
            f"Probability of detection {found.detection_before:.0%} ({settings.search.pod:.0%} wanted): {count} flown "
            f"again, {found.takes_s / 60.0:.0f} min, {found.detection_after:.0%} expected",
        )
        self._progress.extend(found.legs)
        return Phase.LINE
