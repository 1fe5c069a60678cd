"""What is at the same pixels of all frames: dust, vignetting, figures written into the picture.

It belongs to the camera and not to the scene. Frames that agree on it agree best on a plane that depends on how the
camera has turned between them, and on none that is there. So autofocus takes it out first, where there is any.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.focus.measure import CORRELATION_AREA_PX, Agreement, CameraGroups, FocusSignal, focus_signal
from aos_gcs.imaging.model import Frame, Pixels

MIN_PLACES = 8
"""Places of cameras from which on the mean of frames is that of the camera: in that of fewer the scene is left."""

PLACE = 0.25
"""Distance of such places, as a share of that from which frames are compared."""

MIN_COMMON, MIN_SIGNIFICANCE = 0.02, 6.0
"""Agreement at equal pixels from which there is a pattern, and that in standard deviations of chance.

Scenes have 0.0003 to 0.006 in common (windows of F0_flight), vignetting on even ground or written figures 0.5 and more.
"""

_REDUCTION, _STRIDE = 2, 4
"""Edge of the blocks of pixels that are averaged before frames are compared, and distance of those that are."""


@dataclass(frozen=True, slots=True, eq=False)
class WithoutPattern:
    """Frames without the pattern of their camera, computed anew each time they are gone through."""

    frames: Iterable[Frame]
    pattern: NDArray[np.float32]
    """Deviation from the mean of a frame, of the shape of an image; frames of other shapes stay as they are."""

    def __iter__(self) -> Iterator[Frame]:
        """Return one frame after the other."""
        for frame in self.frames:
            is_alike = frame.image.shape == self.pattern.shape
            yield replace(frame, image=frame.image.astype(np.float32) - self.pattern) if is_alike else frame


def without_pattern(frames: Iterable[Frame], separation_m: float) -> Iterable[Frame]:
    """Return the frames without what all have at equal pixels; as they are where that is no more than chance.

    Args:
        frames: gone through once, and once more where there is a pattern.
        separation_m: distance of cameras from which their frames show other parts of the scene; 0: not known, so that
            the frames stay as they are.
    """
    if separation_m <= 0.0:
        return frames
    groups, members = CameraGroups(PLACE * separation_m), list[int]()
    common: Agreement | None = None
    shape: tuple[int, ...] = ()
    for frame in frames:
        shape = shape or frame.image.shape
        members.append(groups.add(frame.pose.position_enu_m))
        if frame.image.shape == shape:
            signal = focus_signal(frame.image, FocusSignal.TEXTURE, _REDUCTION)[::_STRIDE, ::_STRIDE]
            samples = signal.reshape(-1, signal.shape[2])
            common = common or Agreement(len(samples), samples.shape[1])
            common.add(samples, members[-1])
    sizes = np.bincount(members)
    if common is None or len(sizes) < MIN_PLACES:
        return frames
    if common.value() < max(MIN_COMMON, MIN_SIGNIFICANCE * common.scatter(CORRELATION_AREA_PX / _STRIDE**2)):
        return frames
    # Places where the camera has stayed count as one frame: what it has seen there is no pattern.
    pattern, weight = np.zeros(shape, dtype=np.float32), 0.0
    for frame, group in zip(frames, members, strict=True):
        if frame.image.shape == shape:
            pattern += _deviation(frame.image) / np.float32(sizes[group])
            weight += 1.0 / sizes[group]
    return WithoutPattern(frames, pattern / np.float32(weight))


def _deviation(image: Pixels) -> NDArray[np.float32]:
    """Return an image less the mean of each of its channels; 0 where it is not finite."""
    values = image.astype(np.float32)
    known = np.isfinite(values)
    means = np.mean(values, axis=(0, 1), where=known, dtype=np.float64) if known.any() else np.zeros(image.shape[2])
    return np.where(known, values - np.float32(means), np.float32(0.0))
