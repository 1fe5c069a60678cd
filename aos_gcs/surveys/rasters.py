"""The rasters of a whole survey, put together from tiles; large ones live in files."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.surveys.integration import TileResult, Work
from aos_gcs.surveys.significance import AnomalySums


@dataclass(frozen=True, slots=True, eq=False)
class SurveyRasters:
    """Rasters of all tiles together."""

    integral: NDArray[np.float32]
    """Shape (rows, columns, C), NaN where nothing covers."""
    coverage: NDArray[np.uint16]
    anomalies: AnomalySums | None
    """Marks of the detector; None without one."""
    used: frozenset[int]
    """Indices of the images that cover any part."""
    broken: dict[int, str] = field(default_factory=dict)


def assemble(
    work: Work, shape: tuple[int, int], results: Iterable[Sequence[TileResult]], folder: Path
) -> SurveyRasters:
    """Put tiles together as they come.

    Rasters that would take more than the memory allowed live in nameless files in ``folder``, and vanish with the
    arrays.

    Raises:
        ConfigurationError: if the disk has no room for them.
    """
    in_memory = shape[0] * shape[1] * (4 * len(work.bands) + (2 if work.detector is None else 8)) <= work.max_bytes
    integral = _array((*shape, len(work.bands)), np.float32, None if in_memory else folder)
    integral.fill(np.nan)
    coverage = _array(shape, np.uint16, None if in_memory else folder)
    anomalies = None
    if work.detector is not None:
        count, excess = (_array(shape, dtype, None if in_memory else folder) for dtype in (np.uint16, np.uint32))
        anomalies = AnomalySums(count, excess)
    used: set[int] = set()
    broken: dict[int, str] = {}
    for group in results:
        for result in group:
            integral[result.window] = result.integral
            coverage[result.window] = result.coverage
            if anomalies is not None and result.anomalies is not None:
                anomalies.count[result.window] = result.anomalies.count
                anomalies.excess[result.window] = result.anomalies.excess
            used |= result.used
            broken |= result.broken
    return SurveyRasters(integral, coverage, anomalies, frozenset(used), broken)


def _array(shape: tuple[int, ...], dtype: DTypeLike, folder: Path | None) -> NDArray[Any]:
    if folder is None:
        return np.zeros(shape, dtype=dtype)
    size = math.prod(shape) * np.dtype(dtype).itemsize
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            # Its blocks are taken at once: a full disk would end the program when they are written through the map.
            os.posix_fallocate(file.fileno(), 0, size)
            # The map keeps the file's content alive; a new file is full of zeros.
            return np.memmap(file, dtype=dtype, mode="r+", shape=shape)
    except OSError as error:
        raise ConfigurationError(
            f"Cannot keep {size / 1e6:.0f} MB in {folder} while the map is made: {error.strerror or error}. Free some "
            "space, or choose a coarser --ortho or a larger --max-memory."
        ) from error
