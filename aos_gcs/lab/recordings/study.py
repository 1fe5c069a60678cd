"""Windows of frames that move over a recorded flight, each judged as the frames of a swarm would be.

A drone that takes thirty frames along its way sees what thirty vehicles would see at once: every frame counts as one of
a vehicle of its own. The detector marks each frame, the marks are laid on the ground, and the places on which frames
agree are judged by :func:`aos_gcs.imaging.persons.decision.decide` through the same
:class:`~aos_gcs.mission.search.targets.persons.PersonWatch` as in missions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.model import Detector, Frame
from aos_gcs.imaging.persons.decision import CLAIMED
from aos_gcs.lab.recordings.recording import Recording, holds
from aos_gcs.mission.search.targets.persons import PersonWatch
from aos_gcs.surveys.anomalies import MapBlob
from aos_gcs.surveys.images import read_frame
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.significance import DEFAULT_FALSE_ALARMS_PER_HA, MIN_VIEWS, significance_limit
from aos_gcs.surveys.window_anomalies import Detection, find_anomalies

MATCH_M = 2.0
"""Largest horizontal distance at which an anomaly or a claim is that of a person."""
UNCERTAINTY = Uncertainty(position_horizontal_m=0.1, position_vertical_m=0.1, focal_height_m=1.0)
"""Errors of recordings whose poses are computed from the images themselves; the ground is that of a terrain model."""
_HEIGHT_STEP_M = 0.5
"""Heights of the ground that one look at the frames serves: half of it displaces by 0.1 m at 25 degrees off nadir."""


@dataclass(frozen=True, slots=True)
class WindowSettings:
    """Windows, and what agreement of their frames counts.

    Raises:
        ConfigurationError: if a value lies outside its range; the text names it.
    """

    frames: int = 30
    """Frames of a window."""
    stride: int = 30
    """Frames from the start of a window to that of the next one."""
    first: int = 0
    """Index of the first frame of the first window."""
    false_alarms_per_ha: float = DEFAULT_FALSE_ALARMS_PER_HA
    """Places per hectare at which chance may exceed the limit of an anomaly."""
    resolution_m: float = 0.1
    """Edge of a cell."""

    def __post_init__(self) -> None:
        if self.frames < 2 or self.stride < 1 or self.first < 0:
            raise ConfigurationError(
                f"--window must be at least 2, --stride at least 1 and --first at least 0, but they are {self.frames}, "
                f"{self.stride} and {self.first}."
            )
        significance_limit(self.false_alarms_per_ha)
        if not 0.01 <= self.resolution_m <= 1.0:
            raise ConfigurationError(f"--resolution must lie within 0.01 and 1 m, got {self.resolution_m:g}.")

    def starts(self, recording: Recording) -> range:
        """Return the first frames of the windows that fit into a recording.

        Raises:
            ConfigurationError: if none does.
        """
        count = len(recording.survey.images)
        starts = range(self.first, count - self.frames + 1, self.stride)
        if not starts:
            raise ConfigurationError(
                f"--window {self.frames} with --first {self.first} does not fit into {recording.name}, which has "
                f"{count} images."
            )
        return starts


@dataclass(frozen=True, slots=True)
class WindowResult:
    """One window, looked at with one detector."""

    recording: str
    detector: str
    first: int
    """Index of its first frame."""
    frames: int
    persons: int
    """Persons that enough of its frames hold, see :data:`~aos_gcs.surveys.significance.MIN_VIEWS`."""
    detected: int
    """Persons of these near whom the detector has an anomaly."""
    anomalies: int
    false_anomalies: int
    """Anomalies that are at no person."""
    found: int
    """Persons in view that the decision claims."""
    claims: int
    """Places that are claimed; those nearer than :data:`MATCH_M` to a larger one are the same."""
    false_claims: int
    errors_m: tuple[float, ...]
    """Horizontal distance of the nearest claim from each person found."""
    searched_ha: float
    """Area that as many frames see."""


def study_recording(
    recording: Recording,
    detectors: Sequence[Detector],
    settings: WindowSettings,
    advance: Callable[[int], None] = lambda _: None,
) -> list[WindowResult]:
    """Return the result of every window and detector.

    Args:
        recording: the flight.
        detectors: detectors of the anomalies.
        settings: windows.
        advance: reports windows, once per detector, as done.

    Raises:
        ConfigurationError: if no window fits into the recording.
        InputDataError: if an image cannot be read.
    """
    results = []
    for first in settings.starts(recording):
        window = _Window(recording, first, settings)
        for detector in detectors:
            results.append(window.result(detector))
            advance(1)
    return results


class _Window:
    """Frames of a window, and what the decision has seen in them."""

    def __init__(self, recording: Recording, first: int, settings: WindowSettings) -> None:
        self._recording, self._first, self._settings = recording, first, settings
        self._images: tuple[SurveyImage, ...] = recording.survey.images[first : first + settings.frames]
        self._watches: dict[float, PersonWatch] = {}
        """Watches by the ENU height of the plane that they look at."""

    def result(self, detector: Detector) -> WindowResult:
        blobs, searched_ha = self._anomalies(detector)
        claims_m = self._claims(blobs)
        wanted_m = np.array(
            [
                place_m[:2]
                for place_m in self._recording.persons_m
                if sum(holds(image, place_m) for image in self._images) >= MIN_VIEWS
            ]
        ).reshape(-1, 2)
        all_m = self._recording.persons_m[:, :2]
        blobs_m = np.array([blob.position_m[:2] for blob in blobs]).reshape(-1, 2)
        errors_m = [error for error in _distances_m(wanted_m, claims_m) if error <= MATCH_M]
        return WindowResult(
            recording=self._recording.name,
            detector=str(detector),
            first=self._first,
            frames=len(self._images),
            persons=len(wanted_m),
            detected=int(np.count_nonzero(_distances_m(wanted_m, blobs_m) <= MATCH_M)),
            anomalies=len(blobs),
            false_anomalies=int(np.count_nonzero(_distances_m(blobs_m, all_m) > MATCH_M)),
            found=len(errors_m),
            claims=len(claims_m),
            false_claims=int(np.count_nonzero(_distances_m(claims_m, all_m) > MATCH_M)),
            errors_m=tuple(map(float, errors_m)),
            searched_ha=searched_ha,
        )

    def _anomalies(self, detector: Detector) -> tuple[tuple[MapBlob, ...], float]:
        """Return the anomalies, the most significant first, and the area that enough frames see, ha."""
        survey, settings = self._recording.survey, self._settings
        frames = [read_frame(image, survey.bands, number) for number, image in enumerate(self._images, start=1)]
        detection = Detection(detector, false_alarms_per_ha=settings.false_alarms_per_ha)
        found = find_anomalies(frames, self._recording.surface, detection, settings.resolution_m)
        return found.blobs, found.searched_m2 / 1e4

    def _claims(self, blobs: Sequence[MapBlob]) -> NDArray[np.float64]:
        """Return the places that the decision claims, shape (k, 2), in the world of the poses."""
        to_enu = self._recording.to_enu
        claims_m: list[NDArray[np.float64]] = []
        for blob in blobs:
            place_enu_m = to_enu @ np.array(blob.position_m)
            height_m = _HEIGHT_STEP_M * round(float(place_enu_m[2]) / _HEIGHT_STEP_M)
            judgement = self._watch(height_m).judge({0: place_enu_m[:2]}, height_m, UNCERTAINTY).get(0)
            if judgement is None or judgement.verdict.kind not in CLAIMED:
                continue
            known_enu_m = place_enu_m if judgement.place is None else judgement.place.position_enu_m
            place_m = (to_enu.T @ known_enu_m)[:2]
            if all(np.linalg.norm(place_m - other) > MATCH_M for other in claims_m):
                claims_m.append(place_m)
        return np.array(claims_m).reshape(-1, 2)

    def _watch(self, height_m: float) -> PersonWatch:
        if height_m not in self._watches:
            self._watches[height_m] = PersonWatch().look(
                [self._frame(index, image) for index, image in enumerate(self._images, start=1)], height_m
            )
        return self._watches[height_m]

    def _frame(self, number: int, image: SurveyImage) -> Frame:
        frame = read_frame(image, self._recording.survey.bands, number)
        # A thermal recording is a grey picture to its files.
        return replace(frame, bands=("thermal",), pose=self._recording.pose_enu(frame.pose))


def _distances_m(places_m: NDArray[np.float64], others_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance of each place from the nearest of others, infinite if there is none, shape (n,)."""
    apart_m = np.linalg.norm(places_m[:, None] - others_m[None], axis=2)
    return np.asarray(apart_m.min(axis=1, initial=np.inf))
