"""Warmth of the forest and of the sun, which tell whether persons can be told from all else."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aos_gcs.imaging.model import Frame
from aos_gcs.mission.journal import Announcer
from aos_gcs.ports import Severity

WARM_C = 20.0
"""Temperature of forest and ground from which persons are hardly told from them: clothes are about 28 °C."""
_STEPS = 3
"""Steps in a row that must be as warm: single frames may look at a clearing in the sun."""
_STRIDE = 16
"""Distance between the pixels that a frame's median is computed from."""


class BackgroundWatch:
    """Warns operators, once each, of a forest that is nearly as warm as persons, and of sun.

    Args:
        journal: journal that the warning is reported to.
    """

    def __init__(self, journal: Announcer) -> None:
        self._journal = journal
        self._warm_steps = 0
        self._sunny_steps = 0

    def note(self, frames: Sequence[Frame]) -> None:
        """Look at the frames of a step; those without temperatures tell nothing."""
        if self._warm_steps >= _STEPS:
            return
        samples_c = [
            frame.image[::_STRIDE, ::_STRIDE, frame.bands.index("thermal")]
            for frame in frames
            if "thermal" in frame.bands and frame.image.dtype.kind == "f"
        ]
        known_c = [sample_c[np.isfinite(sample_c)] for sample_c in samples_c]
        medians_c = [np.median(sample_c) for sample_c in known_c if sample_c.size]
        if not medians_c:
            return
        background_c = float(np.median(medians_c))
        self._warm_steps = self._warm_steps + 1 if background_c >= WARM_C else 0
        if self._warm_steps == _STEPS:
            self._journal.notice(
                Severity.WARNING,
                f"Forest and ground at {background_c:.0f} °C: persons are hardly warmer, and may be missed or "
                "mistaken. Search by night, or in the cool of the morning",
            )

    def note_sun(self, *, is_sunny: bool) -> None:
        """Note whether the day is sunny, by the frames of a step and of those before."""
        if self._sunny_steps >= _STEPS:
            return
        self._sunny_steps = self._sunny_steps + 1 if is_sunny else 0
        if self._sunny_steps == _STEPS:
            self._journal.notice(
                Severity.WARNING,
                "The sun warms clothes, fur and stones alike: persons are mistaken more often. "
                "Search by night, under clouds, or early in the morning",
            )
