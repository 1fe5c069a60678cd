"""Looks at one body, pooled: what its latest verdicts and its form by all of them say together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.persons.decision import Verdict, pooled
from aos_gcs.imaging.persons.form import Form, FormSums
from aos_gcs.mission.search.persons import Judgement
from aos_gcs.mission.search.same_body import SAME_PLACE_M

POOLED_SIGHTINGS = 20
"""Latest sightings of a target, with gaps or without, whose verdicts decide together what it is. Leaves may show an
animal's bare parts alone for four of them; of ten, they made it a person."""


@dataclass(frozen=True, eq=False)
class Pool:
    """Latest verdicts on one body, and its form."""

    verdicts: tuple[Verdict, ...]
    position_enu_m: NDArray[np.float64]
    """Place by the latest one, shape (2,)."""
    warm_enu_m: tuple[NDArray[np.float64], ...]
    """Latest places of something warm, each of shape (2,)."""
    form_sums: FormSums
    """What all looks tell about its form."""

    @cached_property
    def form(self) -> Form | None:
        """Its form by all looks; None where too few frames show enough of it."""
        return self.form_sums.form()

    @cached_property
    def verdict(self) -> Verdict:
        """What all looks together take it for."""
        return pooled(self.verdicts, self.form)

    def distance_m(self, other: Pool) -> float:
        """Return the distance of the places of two bodies by the latest looks at them."""
        return float(np.linalg.norm(self.position_enu_m - other.position_enu_m))

    def extended(self, latest: Pool) -> Pool:
        """Return the pool with a later one; what is elsewhere and looks like something else is another body.

        What is elsewhere has a form of its own, whatever it looks like: two forms together are that of neither.
        """
        is_elsewhere = self.distance_m(latest) > SAME_PLACE_M
        if is_elsewhere and latest.verdicts[0].kind is not self.verdicts[-1].kind:
            return latest
        return replace(
            latest,
            verdicts=(*self.verdicts, *latest.verdicts)[-POOLED_SIGHTINGS:],
            warm_enu_m=(*self.warm_enu_m, *latest.warm_enu_m)[-POOLED_SIGHTINGS:],
            form_sums=latest.form_sums if is_elsewhere else self.form_sums + latest.form_sums,
        )


def look_at(judgement: Judgement, track_enu_m: NDArray[np.float64]) -> Pool:
    """Return the pool of a single look at a track whose place, shape (2,), is where nothing warm shows."""
    if judgement.place is None:
        return Pool((judgement.verdict,), track_enu_m, (), judgement.form_sums)
    place_enu_m = judgement.place.position_enu_m[:2]
    return Pool((judgement.verdict,), place_enu_m, (place_enu_m,), judgement.form_sums)
