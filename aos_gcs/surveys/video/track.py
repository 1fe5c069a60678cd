"""Pose of the camera at any time of a video, interpolated between the samples of its telemetry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import SEA_LEVEL, AboveHomeM, AmslM, home_below_m
from aos_gcs.geometry.poses import Pose
from aos_gcs.geotags.attitude import R_cam2enu_of_gimbal
from aos_gcs.surveys.video.jumps import without_jumps
from aos_gcs.surveys.video.subtitles import Attitude, CueTelemetry

MAX_GAP_S = 2.5
"""Longest time between two samples over which a pose is interpolated; older aircraft write one a second."""

_HOVER_S = 1.5
"""Time for which a position may stay the same before it is taken for hovering, not for a receiver's interval."""

_LEAST_COURSE_M = 0.5
"""Distance from which the direction of a movement is taken for the course."""


class FlightTrack:
    """Positions and attitudes of a camera over the time of its video, in a world about its first position.

    x is east, y north, and z up from the ground.
    """

    def __init__(
        self, samples: Sequence[CueTelemetry], *, ground_amsl_m: float | None = None, attitude: Attitude | None = None
    ) -> None:
        """Take samples in the order of their times.

        Args:
            samples: telemetry; those without the height or the attitude that is asked for are left out.
            ground_amsl_m: altitude of the ground, to be compared with the absolute altitudes of the samples. None: the
                ground is where the flight began, and their relative altitudes are heights above it.
            attitude: attitude that replaces the gimbal's.

        Raises:
            InputDataError: if heights or attitudes are not recorded.
        """
        heights_m = [(sample, _height_m(sample, ground_amsl_m)) for sample in samples]
        known = [(sample, height_m) for sample, height_m in heights_m if height_m is not None]
        if not known:
            missing = "rel_alt; give the altitude of the ground (--ground)" if ground_amsl_m is None else "abs_alt"
            raise InputDataError(f"The telemetry has no {missing}.")
        known = [(sample, m) for sample, m in known if attitude is not None or sample.gimbal_deg is not None]
        if not known:
            raise InputDataError(
                "The telemetry has no angles of the gimbal (gb_yaw, gb_pitch, gb_roll): say where the camera looked "
                "(--attitude YAW,PITCH, or --attitude course,-90 for one that looked down, its upper edge forward)."
            )
        plausible = {id(sample) for sample in without_jumps([sample for sample, _ in known])}
        self.jumps = len(known) - len(plausible)
        """Number of samples left out because no aircraft gets to their positions in time."""
        known = [(sample, height_m) for sample, height_m in known if id(sample) in plausible]
        first, first_height_m = known[0]
        ground_m = SEA_LEVEL
        if ground_amsl_m is not None:
            ground_m = AmslM(ground_amsl_m)
        elif first.altitude_amsl_m is not None:
            # Without an absolute altitude only the scale suffers, by a millionth per six metres.
            ground_m = home_below_m(first.altitude_amsl_m, AboveHomeM(first_height_m))
        self.origin = GeodeticPosition(first.latitude_deg, first.longitude_deg, ground_m)
        """Origin of the world: below the first position, on the ground."""
        frame = LocalFrame(self.origin)
        places = [
            GeodeticPosition(s.latitude_deg, s.longitude_deg, AmslM(ground_m + height_m)) for s, height_m in known
        ]
        self._times_s = np.array([sample.time_s for sample, _ in known])
        self._zooms = np.array([sample.zoom for sample, _ in known])
        positions_m = np.array([frame.to_enu(place) for place in places])
        knots = _changes(self._times_s, positions_m)
        self._knots_s, self._knots_m = self._times_s[knots], positions_m[knots]
        self._attitude = attitude or _slerp(self._times_s, [sample.gimbal_deg for sample, _ in known])

    @property
    def end_s(self) -> float:
        """Time of the last sample."""
        return float(self._times_s[-1])

    def is_known(self, time_s: float) -> bool:
        """Return whether there is telemetry on both sides of a time, or close to it."""
        after = int(np.searchsorted(self._times_s, time_s))
        nearest = self._times_s[max(after - 1, 0) : after + 1]
        return bool(np.abs(nearest - time_s).min() <= MAX_GAP_S / 2)

    def zoom(self, time_s: float) -> float:
        """Return the digital zoom at a time."""
        return float(self._zooms[max(int(np.searchsorted(self._times_s, time_s, side="right")) - 1, 0)])

    def position_m(self, time_s: float) -> NDArray[np.float64]:
        """Return the position at a time, shape (3,)."""
        return np.array([np.interp(time_s, self._knots_s, self._knots_m[:, axis]) for axis in range(3)])

    def pose(self, time_s: float) -> Pose:
        """Return the pose at a time; beyond both ends, that of the end."""
        if isinstance(self._attitude, Slerp):
            within_s = float(np.clip(time_s, self._times_s[0], self._times_s[-1]))
            R_cam2enu = np.asarray(self._attitude(within_s).as_matrix())
        else:
            yaw_deg = self._attitude.yaw_deg
            yaw_deg = self._course_deg(time_s) if yaw_deg is None else yaw_deg
            R_cam2enu = R_cam2enu_of_gimbal(yaw_deg, self._attitude.pitch_deg, self._attitude.roll_deg)
        return Pose(self.position_m(time_s), R_cam2enu)

    def _course_deg(self, time_s: float) -> float:
        """Return the direction of flight, over the shortest time about another in which it can be told."""
        half_s = 0.5
        while half_s < 2.0 * (self._times_s[-1] - self._times_s[0]):
            east_m, north_m, _ = self.position_m(time_s + half_s) - self.position_m(time_s - half_s)
            if math.hypot(east_m, north_m) >= _LEAST_COURSE_M:
                return math.degrees(math.atan2(east_m, north_m))
            half_s *= 2.0
        raise InputDataError("The aircraft did not move, so that its course is not known: give YAW in degrees.")


def _height_m(sample: CueTelemetry, ground_amsl_m: float | None) -> float | None:
    if ground_amsl_m is None:
        return sample.relative_altitude_m
    return None if sample.altitude_amsl_m is None else sample.altitude_amsl_m - ground_amsl_m


def _changes(times_s: NDArray[np.float64], positions_m: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the samples at which the position changes, and the last one before the end of a hover.

    Subtitles come at the rate of the pictures, positions more slowly: repeated, they would make a stair of the track.
    """
    starts = [0, *(np.flatnonzero(np.any(np.diff(positions_m, axis=0) != 0.0, axis=1)) + 1).tolist()]
    ends = [
        after - 1
        for before, after in pairwise([*starts, len(times_s)])
        if times_s[after - 1] - times_s[before] > _HOVER_S
    ]
    return np.unique([*starts, *ends])


def _slerp(times_s: NDArray[np.float64], gimbals_deg: Sequence[tuple[float, float, float] | None]) -> Slerp:
    # Two cues of one time would leave no time to turn in.
    times_s, first = np.unique(times_s, return_index=True)
    turns = np.array([R_cam2enu_of_gimbal(*angles) for angles in gimbals_deg if angles is not None])[first]
    if len(times_s) == 1:
        times_s, turns = np.array([times_s[0], times_s[0] + 1.0]), np.repeat(turns, 2, axis=0)
    return Slerp(times_s, Rotation.from_matrix(turns))
