"""Heights of several files where they overlap."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import DTypeLike, NDArray

from aos_gcs.errors import InputDataError

MAX_DISAGREEMENT_M: Final = 2.0
"""Greatest difference between two files where they overlap: what resampling makes of steep ground."""


class MergedHeights:
    """Heights of cells, each from the first file that has one; NaN where none has.

    Args:
        shape: shape of the cells.
        dtype: type of the heights, floating.
    """

    def __init__(self, shape: tuple[int, ...], dtype: DTypeLike) -> None:
        self.heights: NDArray[Any] = np.full(shape, np.nan, dtype=dtype)
        self._source = np.full(shape, -1, dtype=np.int32)
        """Index of the path that each height came from; -1 where there is none."""
        self._paths: list[Path] = []

    def add(self, cells: Any, heights: NDArray[Any], path: Path) -> None:
        """Add the heights of a file, NaN in its holes, at an index of cells.

        Raises:
            InputDataError: they differ by more than 2 m from those of an earlier file at a cell; names both.
        """
        former, source = self.heights[cells], self._source[cells]
        if (source >= 0).any():
            differences_m = np.nan_to_num(np.abs(np.asarray(heights, dtype=np.float64) - former))
            if (most_m := float(differences_m.max())) > MAX_DISAGREEMENT_M:
                before = self._paths[source.flat[differences_m.argmax()]]
                raise InputDataError(
                    f"The elevation models {path} and {before} overlap and contradict each other by up to "
                    f"{most_m:.1f} m; {MAX_DISAGREEMENT_M:g} m are allowed. Leave out the wrong one, or correct its "
                    "datum or unit."
                )
        is_new = np.isnan(former) & ~np.isnan(heights)
        self.heights[cells] = np.where(is_new, heights, former)
        self._source[cells] = np.where(is_new, len(self._paths), source)
        self._paths.append(path)
