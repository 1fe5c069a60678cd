"""The latest motion of one vehicle, and its pose at any time in between.

Positions are interpolated by cubic Hermite splines through positions and velocities, attitudes on the shortest arc
(Shoemake, *Animating rotation with quaternion curves*, SIGGRAPH 1985). Past the latest report, positions go on with
their velocity and attitudes stay. All times are seconds of one clock, the vehicle's time since boot.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from aos_drivers.frames.errors import FrameRefusedError
from aos_drivers.frames.poses.gimbal import GimbalAttitude, R_heading2ned, heading_of
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_gcs.geometry.rotations import R_from_yaw_pitch_roll, slerp

KEPT_S = 20.0
_MAX_SAMPLES = 1024
_RESTART_S = 2.0
"""A time so much before the latest one is that of another boot; a smaller step back is a late packet."""

T = TypeVar("T")


Motion = tuple[float, float, float, float, float, float]
"""Latitude and longitude (degrees), altitude above mean sea level (m); velocity to the east, north and up (m/s).

Plain numbers: garbage collection looks through all objects that are kept, of which a swarm's would be many.
"""


def position_of(motion: Motion) -> GeodeticPosition:
    """Return the position of a motion."""
    return GeodeticPosition(motion[0], motion[1], AmslM(motion[2]))


class Samples(Generic[T]):
    """Values by time. Buffered: 20 s and at most 1024 values, the oldest are dropped; so are late ones."""

    __slots__ = ("_times_s", "_values")

    def __init__(self) -> None:
        self._times_s: list[float] = []
        self._values: list[T] = []

    def __len__(self) -> int:
        return len(self._times_s)

    @property
    def latest_s(self) -> float | None:
        """Time of the latest value."""
        return self._times_s[-1] if self._times_s else None

    @property
    def values(self) -> Sequence[T]:
        """Values, oldest first."""
        return self._values

    def add(self, at_s: float, value: T) -> None:
        """Take a value over."""
        times_s = self._times_s
        if times_s and at_s <= times_s[-1]:
            if at_s > times_s[-1] - _RESTART_S:
                return
            times_s.clear()
            self._values.clear()
        times_s.append(at_s)
        self._values.append(value)
        if times_s[0] <= at_s - KEPT_S or len(times_s) > _MAX_SAMPLES:
            outdated = max(bisect_right(times_s, at_s - KEPT_S), len(times_s) - _MAX_SAMPLES)
            del times_s[:outdated], self._values[:outdated]

    def around(self, at_s: float, max_age_s: float) -> tuple[tuple[float, T], tuple[float, T]] | None:
        """Return the samples before and after a time, twice the same one beyond either end.

        None where the nearest of them is further away than ``max_age_s``.
        """
        if not self._times_s:
            return None
        after = min(bisect_right(self._times_s, at_s), len(self._times_s) - 1)
        before = max(0, bisect_right(self._times_s, at_s) - 1)
        if min(abs(at_s - self._times_s[before]), abs(at_s - self._times_s[after])) > max_age_s:
            return None
        return (self._times_s[before], self._values[before]), (self._times_s[after], self._values[after])


class PoseTrack:
    """Recent reports of a vehicle's motion and of its gimbal's."""

    __slots__ = ("_attitudes", "_gimbal_follows_heading", "_gimbals", "motions")

    def __init__(self) -> None:
        self.motions: Samples[Motion] = Samples()
        self._attitudes: Samples[tuple[float, float, float]] = Samples()
        """Yaw, pitch and roll: only the few that are needed become matrices."""
        self._gimbals: Samples[NDArray[np.float64]] = Samples()
        self._gimbal_follows_heading = False

    def add_motion(self, at_s: float, motion: Motion) -> None:
        """Add a position and a velocity of the vehicle."""
        self.motions.add(at_s, motion)

    def add_attitude(self, at_s: float, yaw_pitch_roll_rad: tuple[float, float, float]) -> None:
        """Add an attitude of the vehicle."""
        self._attitudes.add(at_s, yaw_pitch_roll_rad)

    def add_gimbal(self, at_s: float, attitude: GimbalAttitude) -> None:
        """Add an attitude of the gimbal; when its reference frame changes, earlier ones are dropped."""
        if attitude.follows_heading != self._gimbal_follows_heading:
            self._gimbals, self._gimbal_follows_heading = Samples(), attitude.follows_heading
        self._gimbals.add(at_s, attitude.R_gimbal2level)

    def covers(self, at_s: float, *, with_gimbal: bool = False) -> bool:
        """Return whether reports from ``at_s`` or later are there, so that nothing has to be extrapolated."""
        latest = [self.motions.latest_s, self._attitudes.latest_s]
        if with_gimbal:
            latest.append(self._gimbals.latest_s)
        return all(latest_s is not None and latest_s >= at_s for latest_s in latest)

    def position_at(self, at_s: float, max_age_s: float) -> GeodeticPosition:
        """Return the position of the vehicle.

        Raises:
            FrameRefusedError: it did not report within ``max_age_s`` of that time.
        """
        around = self.motions.around(at_s, max_age_s)
        if around is None:
            raise _stale("position", self.motions.latest_s, at_s, max_age_s)
        (before_s, before), (after_s, after) = around
        frame = LocalFrame(position_of(before))
        start, start_v = np.zeros(3), np.array(before[3:])
        if after_s == before_s:
            return frame.to_geodetic(start + (at_s - before_s) * start_v)
        end, span_s = frame.to_enu(position_of(after)), after_s - before_s
        share = (at_s - before_s) / span_s
        # The cubic Hermite polynomial from the first position, which is the origin.
        along_m = share**2 * (3.0 - 2.0 * share) * end
        along_m += span_s * share * (1.0 - share) * ((1.0 - share) * start_v - share * np.array(after[3:]))
        return frame.to_geodetic(along_m)

    def R_body2ned_at(self, at_s: float, max_age_s: float) -> NDArray[np.float64]:
        """Return the attitude of the vehicle, shape (3, 3); raises like :meth:`position_at`."""
        return _rotation_at(self._attitudes, R_from_yaw_pitch_roll, "attitude", at_s, max_age_s)

    def R_gimbal2ned_at(self, at_s: float, max_age_s: float) -> NDArray[np.float64]:
        """Return the attitude of the gimbal, shape (3, 3); raises like :meth:`position_at`."""
        R_gimbal2level = _rotation_at(self._gimbals, np.asarray, "gimbal attitude", at_s, max_age_s)
        if not self._gimbal_follows_heading:
            return R_gimbal2level
        return R_heading2ned(heading_of(self.R_body2ned_at(at_s, max_age_s))) @ R_gimbal2level


def _rotation_at(
    samples: Samples[T], matrix: Callable[[T], NDArray[np.float64]], name: str, at_s: float, max_age_s: float
) -> NDArray[np.float64]:
    around = samples.around(at_s, max_age_s)
    if around is None:
        raise _stale(name, samples.latest_s, at_s, max_age_s)
    (before_s, before), (after_s, after) = around
    if after_s == before_s:
        return matrix(before)
    return slerp((at_s - before_s) / (after_s - before_s), matrix(before), matrix(after))


def _stale(name: str, latest_s: float | None, at_s: float, max_age_s: float) -> FrameRefusedError:
    if latest_s is None:
        return FrameRefusedError(f"the vehicle reports no {name}")
    age_s = at_s - latest_s
    when = f"its latest is {age_s:.2f} s older" if age_s > 0.0 else "there is a gap, or the frame is older than all"
    return FrameRefusedError(
        f"no {name} of the vehicle near the time of exposure: {when}; the limit is {max_age_s:g} s (max_pose_age_s)"
    )
