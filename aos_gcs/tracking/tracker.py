"""Several targets followed at once: association, confirmation and deletion of tracks.

Measurements go to tracks by greatest joint likelihood (global nearest neighbour: Blackman and Popoli, *Design and
Analysis of Modern Tracking Systems*, chapter 6); those that are likelier something new begin tracks. A track is
confirmed once M of its first N opportunities have shown it, and deleted when they cannot any more; a confirmed one
after a run of misses. Only steps that look at a track's place are opportunities. :func:`observe` takes the tracks in
and gives new ones: state is data.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.tracking.motion import WALKING, Motion, MotionSettings, begin, density, predict, update

FRESH_S = 20.0
"""Time after its latest measurement for which a track may be met anywhere that a runner can have reached."""


@dataclass(frozen=True, slots=True)
class TrackingSettings:
    """Rules by which measurements become a track.

    Raises:
        ConfigurationError: a value is out of range; the text names it.
    """

    new_per_m2: float = 2e-5
    """Density of things seen that belong to no track: a measurement that a track predicts with less begins another."""
    confirm_hits: int = 4
    """Measurements (M) ..."""
    confirm_window: int = 6
    """... of the first so many opportunities (N) that make a track."""
    max_misses: int = 10
    """Opportunities missed in a row after which a confirmed track ends."""
    forget_s: float = 300.0
    """Time without a measurement after which any track ends."""
    max_surprise_m: float = 5.0
    """Distance from its predicted position up to which some tracks take a measurement, for they would take whatever is
    seen next: one that was not seen for ``FRESH_S``, which is expected anywhere by then, and one that has been seen
    again where it was, which need not have gone when something else comes into view."""
    motion: MotionSettings = field(default_factory=MotionSettings)

    def __post_init__(self) -> None:
        if not 1 <= self.confirm_hits <= self.confirm_window:
            raise ConfigurationError(
                f"confirm_hits must lie within 1 and confirm_window ({self.confirm_window}), but is "
                f"{self.confirm_hits}."
            )
        for name in ("new_per_m2", "max_misses", "forget_s", "max_surprise_m"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ConfigurationError(f"{name} must be a finite number above 0, but is {value}.")


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """Horizontal position at which something was seen."""

    position_enu_m: NDArray[np.float64]
    """Shape (2,)."""
    random_m2: NDArray[np.float64]
    """Covariance of the error that is drawn anew in every step, shape (2, 2)."""
    systematic_m2: NDArray[np.float64]
    """Covariance of the error that stays from step to step, shape (2, 2)."""

    @property
    def covariance_m2(self) -> NDArray[np.float64]:
        """Covariance of the whole error, shape (2, 2)."""
        return np.asarray(self.random_m2 + self.systematic_m2)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """One target."""

    track_id: int
    """Counts from 1; never given twice."""
    motion: Motion
    """Covariance as if all errors were drawn anew in every step."""
    systematic_m2: NDArray[np.float64]
    """Covariance of the part of the error that does not average out, shape (2, 2)."""
    measured_m2: NDArray[np.float64]
    """Covariance of the latest measurement, shape (2, 2)."""
    seen_at_s: float
    """Moment of the latest measurement."""
    hits: int = 1
    opportunities: int = 1
    misses: int = 0
    """Misses in a row, up to now."""
    confirmed: bool = False
    surprise_m: float | None = None
    """Distance of the latest measurement from where it was predicted; None for the first."""

    @property
    def position_enu_m(self) -> NDArray[np.float64]:
        """Shape (2,)."""
        return self.motion.state[:2]

    @property
    def velocity_enu_mps(self) -> NDArray[np.float64]:
        """Shape (2,)."""
        return self.motion.state[2:]

    @property
    def walking_share(self) -> float:
        """Probability that the target walks."""
        return float(self.motion.shares[WALKING])

    @property
    def stays(self) -> bool:
        """Whether the target more likely stays than walks."""
        return self.walking_share <= 0.5

    @property
    def covariance_m2(self) -> NDArray[np.float64]:
        """Covariance of the position, shape (2, 2).

        The filter's own covariance P shrinks as if every error averaged out. The systematic part S does not: for N
        measurements of covariance R + S the error is R / N + S, which with P = (R + S) / N is P + S (1 - 1 / N).
        """
        P = self.motion.covariance[:2, :2]
        averaged = min(1.0, float(np.trace(P) / np.trace(self.measured_m2)))
        return np.asarray(P + (1.0 - averaged) * self.systematic_m2)


@dataclass(frozen=True, slots=True)
class Tracks:
    """All tracks at one moment."""

    tracks: tuple[Track, ...] = ()
    next_id: int = 1

    def find(self, track_id: int | None) -> Track | None:
        """Return the track of that id, or None when it has ended."""
        return next((track for track in self.tracks if track.track_id == track_id), None)


def observe(
    before: Tracks,
    measurements: Sequence[Measurement],
    now_s: float,
    settings: TrackingSettings,
    is_covered: Callable[[NDArray[np.float64]], bool],
) -> tuple[Tracks, tuple[int, ...]]:
    """Return the tracks after one step, and the id of the track that each measurement belongs to.

    Args:
        before: tracks of the previous step.
        measurements: measurements of this step, one per thing seen.
        now_s: their moment, not before that of the previous step.
        settings: see :class:`TrackingSettings`.
        is_covered: whether the step looked at a position, shape (2,).
    """
    predicted = [replace(track, motion=predict(track.motion, now_s, settings.motion)) for track in before.tracks]
    pairs = _assign(predicted, measurements, settings)
    ids, next_id, after = [], before.next_id, list[Track]()
    for row, track in enumerate(predicted):
        if row in pairs:
            after.append(_hit(track, measurements[pairs[row]], settings))
        else:
            after.append(_missed(track) if is_covered(track.position_enu_m) else track)
    owner = {column: predicted[row].track_id for row, column in pairs.items()}
    for column, measurement in enumerate(measurements):
        if column not in owner:
            owner[column], next_id = next_id, next_id + 1
            after.append(_begun(owner[column], measurement, now_s, settings))
        ids.append(owner[column])
    return Tracks(tuple(track for track in after if _is_alive(track, settings)), next_id), tuple(ids)


def _assign(tracks: Sequence[Track], measurements: Sequence[Measurement], settings: TrackingSettings) -> dict[int, int]:
    """Return the measurement of each track that has one, by their indices."""
    if not tracks or not measurements:
        return {}
    places_m = np.array([track.position_enu_m for track in tracks])
    offsets_m = np.array([one.position_enu_m for one in measurements]) - places_m[:, np.newaxis]
    is_limited = np.array([_has_stayed(track) or track.motion.at_s - track.seen_at_s > FRESH_S for track in tracks])
    is_possible = ~is_limited[:, np.newaxis] | (np.linalg.norm(offsets_m, axis=-1) <= settings.max_surprise_m)
    gains = np.zeros(is_possible.shape)
    # Most pairs are far apart.
    for row, column in zip(*np.nonzero(is_possible), strict=True):
        one = measurements[column]
        gains[row, column] = density(tracks[row].motion, one.position_enu_m, one.covariance_m2) / settings.new_per_m2
    # What is likelier new gains nothing, whichever track it is left with.
    rows, columns = scipy.optimize.linear_sum_assignment(np.log(np.maximum(gains, 1.0)), maximize=True)
    return {int(row): int(column) for row, column in zip(rows, columns, strict=True) if gains[row, column] > 1.0}


def _has_stayed(track: Track) -> bool:
    return track.hits > 1 and track.stays


def _begun(track_id: int, measurement: Measurement, now_s: float, settings: TrackingSettings) -> Track:
    covariance_m2 = measurement.covariance_m2
    motion = begin(measurement.position_enu_m, covariance_m2, now_s, settings.motion)
    return Track(
        track_id,
        motion,
        systematic_m2=measurement.systematic_m2,
        measured_m2=covariance_m2,
        seen_at_s=now_s,
        confirmed=settings.confirm_hits == 1,
    )


def _hit(track: Track, measurement: Measurement, settings: TrackingSettings) -> Track:
    P, R = track.motion.covariance[:2, :2], measurement.covariance_m2
    # Mixed in by the share that the filter takes of the measurement: no less than the variance of the mixed errors,
    # however they are correlated.
    share = float(np.trace(P) / np.trace(P + R))
    hits = track.hits + 1
    return replace(
        track,
        motion=update(track.motion, measurement.position_enu_m, R),
        systematic_m2=(1.0 - share) * track.systematic_m2 + share * measurement.systematic_m2,
        measured_m2=R,
        seen_at_s=track.motion.at_s,
        hits=hits,
        opportunities=track.opportunities + 1,
        misses=0,
        confirmed=track.confirmed or hits >= settings.confirm_hits,
        surprise_m=float(np.linalg.norm(measurement.position_enu_m - track.position_enu_m)),
    )


def _missed(track: Track) -> Track:
    return replace(track, opportunities=track.opportunities + 1, misses=track.misses + 1)


def _is_alive(track: Track, settings: TrackingSettings) -> bool:
    if track.motion.at_s - track.seen_at_s > settings.forget_s:
        return False
    if track.confirmed:
        return track.misses < settings.max_misses
    return track.opportunities - track.hits <= settings.confirm_window - settings.confirm_hits
