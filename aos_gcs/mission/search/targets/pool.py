"""Looks at one body, pooled: what its latest verdicts and its form by all of them say together.

A body behind leaves is out of view for longer than its track lives, and has another one when it comes into view again.
So pools outlive the tracks of what stays where it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.persons.decision import Verdict, pooled, telling
from aos_gcs.imaging.persons.form import Form, FormSums
from aos_gcs.mission.search.targets.persons import Judgement
from aos_gcs.mission.search.targets.same_body import PIECES_M, SAME_PLACE_M

POOLED_SIGHTINGS = 20
"""Latest sightings of a target that tell what it is, with gaps or without, whose verdicts decide together. Leaves may
show an animal's bare parts alone for four of them; of ten, they made it a person."""
MAX_FORMER = 100
"""Bodies out of view whose pools are kept, the latest ones."""


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
        """Form of the body by all looks; None where too few frames show enough of it."""
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
            verdicts=(*telling(self.verdicts), *latest.verdicts)[-POOLED_SIGHTINGS:],
            warm_enu_m=(*self.warm_enu_m, *latest.warm_enu_m)[-POOLED_SIGHTINGS:],
            form_sums=latest.form_sums if is_elsewhere else self.form_sums + latest.form_sums,
        )


def look_at(judgement: Judgement, track_enu_m: NDArray[np.float64]) -> Pool:
    """Return the pool of a single look at a track whose place, shape (2,), is where nothing warm shows."""
    if judgement.place is None:
        return Pool((judgement.verdict,), track_enu_m, (), judgement.form_sums)
    place_enu_m = judgement.place.position_enu_m[:2]
    return Pool((judgement.verdict,), place_enu_m, (place_enu_m,), judgement.form_sums)


class Pools:
    """Pools of the bodies that are tracked, and of those whose tracks have ended."""

    def __init__(self) -> None:
        self._of_tracks: dict[int, Pool] = {}
        self._stays: dict[int, bool] = {}
        """Whether the body of each track more likely stays than walks."""
        self._former: list[Pool] = []
        """Pools whose tracks have ended, the latest last."""

    def get(self, track_id: int) -> Pool | None:
        """Return the pool of a track; None if nothing was seen of it yet."""
        return self._of_tracks.get(track_id)

    def follow(self, stays: Mapping[int, bool]) -> None:
        """Set the pools of tracks that have ended aside; those of bodies that walked go with them.

        Args:
            stays: whether its body more likely stays than walks, by the ids of the present tracks.
        """
        for track_id in sorted(self._of_tracks.keys() - stays.keys()):
            pool = self._of_tracks.pop(track_id)
            if self._stays.get(track_id, False) and telling(pool.verdicts):
                self._former = [*self._former, pool][-MAX_FORMER:]
        self._stays = dict(stays)

    def add(self, track_id: int, look: Pool) -> None:
        """Add a look at a track to those before it; a new track at a known body goes on with what is known of it.

        Leaves cut a body in pieces: without this, each of its tracks would be judged anew by a few looks.
        """
        if (pool := self._of_tracks.get(track_id)) is not None:
            self._of_tracks[track_id] = pool.extended(look)
        elif (known := _nearest(look, list(self._of_tracks.values()))) is not None:
            self._of_tracks[track_id] = known
        elif (former := _nearest(look, self._former)) is not None:
            self._former.remove(former)
            self._of_tracks[track_id] = former.extended(look)
        else:
            self._of_tracks[track_id] = look


def _nearest(look: Pool, pools: Sequence[Pool]) -> Pool | None:
    """Return the pool of the body that a look is at, if it is one of these."""
    near = [pool for pool in pools if pool.distance_m(look) <= PIECES_M]
    return min(near, key=look.distance_m, default=None)
