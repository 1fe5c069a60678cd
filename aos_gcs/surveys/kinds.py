"""Kind of the pictures of a recording, their bands and the type of their values, by a sample of them.

One picture alone may be another: grey among colours, or black as its lens was still covered.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.equal_bands import GREY
from aos_gcs.errors import InputDataError
from aos_gcs.imaging.workers import parallel_map
from aos_gcs.surveys.images import THERMAL, bands_of, read_pixels
from aos_gcs.surveys.radiometric.settings import TemperatureSettings

SAMPLE = 9
"""Pictures that are looked at."""
_STRIDE_PX = 16


@dataclass(frozen=True, slots=True)
class Kind:
    """What all pictures of a recording have in common; those of a camera that names its sensor may differ in size."""

    bands: tuple[str, ...]
    dtype: np.dtype[Any]
    size_px: tuple[int, int]
    """Height and width."""

    def __str__(self) -> str:
        """Return the kind in words."""
        colours = "grey" if self.bands == GREY else "in temperatures" if self.bands == THERMAL else "in colour"
        values = f"{8 * self.dtype.itemsize}-bit{' floating-point' if self.dtype.kind == 'f' else ''} values"
        return f"{colours} with {values}"


@dataclass(frozen=True, slots=True)
class UsualKind:
    """The kind that most pictures of a sample have."""

    kind: Kind
    odd: Mapping[Path, str]
    """Reasons why pictures of the sample do not fit: those of another kind, without any content, or unreadable."""


def usual_kind(
    paths: Sequence[Path], temperatures: TemperatureSettings | None, name: str, *, same_size: bool = True
) -> UsualKind:
    """Return the kind of the pictures of a recording. A picture that is the same everywhere does not count.

    Args:
        paths: pictures, at least one.
        temperatures: settings under which temperatures are read; None: pictures are read.
        name: the pictures as a message calls them.
        same_size: whether those of another size are of another kind.

    Raises:
        InputDataError: if none can be read, or all are the same everywhere.
    """
    look = partial(_look, temperatures=temperatures)
    chosen = sorted({round(index) for index in np.linspace(0, len(paths) - 1, SAMPLE)})
    seen = dict(zip(chosen, parallel_map(look, [paths[index] for index in chosen]), strict=True))
    for index in range(len(paths)):
        if any(isinstance(one, Kind) for one in seen.values()):
            break
        if index not in seen:
            seen[index] = look(paths[index])
    kinds = [one for one in seen.values() if isinstance(one, Kind)]
    unusable = {paths[index]: one for index, one in seen.items() if isinstance(one, _Unusable)}
    if not kinds:
        raise InputDataError(_nothing_usable(unusable, name))

    def key(kind: Kind) -> Hashable:
        return kind.bands, kind.dtype, kind.size_px if same_size else None

    usual_key = Counter(map(key, kinds)).most_common(1)[0][0]
    usual = next(kind for kind in kinds if key(kind) == usual_key)
    odd = {path: one.reason for path, one in unusable.items()}
    for index, one in seen.items():
        if isinstance(one, Kind) and key(one) != usual_key:
            odd[paths[index]] = f"it is {one}, where most pictures are {usual}"
    return UsualKind(usual, odd)


@dataclass(frozen=True, slots=True)
class _Unusable:
    """A picture that tells no kind."""

    reason: str
    is_constant: bool


def _look(path: Path, temperatures: TemperatureSettings | None) -> Kind | _Unusable:
    try:
        pixels = read_pixels(path, temperatures)
    except InputDataError as error:
        return _Unusable(str(error), is_constant=False)
    if _is_constant(pixels):
        values = ", ".join(f"{value:g}" for value in pixels[0, 0])
        return _Unusable(f"it is the same everywhere ({values})", is_constant=True)
    height_px, width_px, _ = pixels.shape
    return Kind(bands_of(pixels) if temperatures is None else THERMAL, pixels.dtype, (height_px, width_px))


def _is_constant(pixels: NDArray[Any]) -> bool:
    first = pixels[0, 0]
    return bool((pixels[::_STRIDE_PX, ::_STRIDE_PX] == first).all() and (pixels == first).all())


def _nothing_usable(unusable: Mapping[Path, _Unusable], name: str) -> str:
    """Return why no picture of a recording can be used."""
    path, one = next(((path, one) for path, one in unusable.items() if one.is_constant), next(iter(unusable.items())))
    text = f"None of the {len(unusable)} {name} can be used; {path.name}: {one.reason}"
    if one.is_constant:
        text += ". Was the lens covered? Choose pictures that show something."
    return text
