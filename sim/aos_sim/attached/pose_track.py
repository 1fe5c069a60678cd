"""The latest poses of a vehicle, and its pose between two of them."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from dataclasses import dataclass

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AmslM

MAX_GAP_S = 1.0
"""Poses farther apart than this say nothing about the time between them."""
_KEPT = 256


@dataclass(frozen=True, slots=True)
class TimedPose:
    """Pose of a vehicle at one moment."""

    at_s: float
    """Time since the vehicle has started."""
    position: GeodeticPosition
    heading_rad: float
    """Clockwise from north."""


class PoseTrack:
    """Poses in the order of time. Policy: the latest 256 are kept; one that is not later than the last is dropped."""

    def __init__(self) -> None:
        self._poses: deque[TimedPose] = deque(maxlen=_KEPT)

    @property
    def is_empty(self) -> bool:
        """Whether no pose is known."""
        return not self._poses

    def add(self, pose: TimedPose) -> None:
        """Append a pose."""
        if not self._poses or pose.at_s > self._poses[-1].at_s:
            self._poses.append(pose)

    def clear(self) -> None:
        """Forget all poses."""
        self._poses.clear()

    def at(self, moment_s: float) -> TimedPose | None:
        """Return the pose at a moment between two poses that are at most ``MAX_GAP_S`` apart, else None.

        Position and heading change evenly from one pose to the next; latitude and longitude do, too, which is exact
        enough over the metres of a second's flight.
        """
        later = bisect_left(self._poses, moment_s, key=lambda pose: pose.at_s)
        if later == len(self._poses):
            return None
        after = self._poses[later]
        if after.at_s == moment_s:
            return after
        if later == 0:
            return None
        before = self._poses[later - 1]
        if after.at_s - before.at_s > MAX_GAP_S:
            return None
        return _between(before, after, (moment_s - before.at_s) / (after.at_s - before.at_s), moment_s)


def _between(before: TimedPose, after: TimedPose, share: float, moment_s: float) -> TimedPose:
    start, end = before.position, after.position
    turn_rad = (after.heading_rad - before.heading_rad + math.pi) % (2 * math.pi) - math.pi
    return TimedPose(
        at_s=moment_s,
        position=GeodeticPosition(
            start.latitude_deg + share * (end.latitude_deg - start.latitude_deg),
            start.longitude_deg + share * (end.longitude_deg - start.longitude_deg),
            AmslM(start.altitude_amsl_m + share * (end.altitude_amsl_m - start.altitude_amsl_m)),
        ),
        heading_rad=(before.heading_rad + share * turn_rad) % (2 * math.pi),
    )
