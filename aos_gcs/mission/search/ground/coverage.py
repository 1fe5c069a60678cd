"""Coverage: how often each place of the search area was in a frame, and what share of the ground that shows.

Frames are counted, not views through different gaps: where vehicles stand closer than the canopy's useful spacing, the
visibility is an upper bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.polygon import Polygon
from aos_gcs.airspace.raster import PlanRaster
from aos_gcs.imaging.pictures import RasterPicture, encode_png

FULL_COUNT: Final = 20
"""Number of frames from which the colour no longer changes."""
_ALPHA = np.uint8(150)
"""Opacity; the map below must stay readable."""


class CoverageMap:
    """Counts frames over the search area.

    Args:
        area_enu_m: the search area.
        occlusion: share of the ground that one frame does not see; None where the forest is not known.
    """

    def __init__(self, area_enu_m: Polygon, occlusion: float | None) -> None:
        self._raster = PlanRaster.around(area_enu_m)
        self._inside = self._raster.inside([area_enu_m])
        self._area_m2 = self._raster.area_m2(self._inside)
        self._occlusion = occlusion
        self._counts: NDArray[np.uint16] = np.zeros(self._raster.shape, dtype=np.uint16)
        self.covered_fraction = 0.0
        """Share of the area that was in a frame at least once."""

    def add(self, footprints: Sequence[Polygon]) -> None:
        """Count the frames of a step by what they show of the ground."""
        counts = self._counts
        for footprint in footprints:
            if footprint:
                counts = counts + self._raster.inside([footprint])
        self.set_counts(counts)

    @property
    def counts(self) -> NDArray[np.uint16]:
        """Number of frames that have shown each cell."""
        return self._counts

    def set_counts(self, counts: NDArray[np.uint16]) -> None:
        """Replace the counts."""
        self._counts = counts
        self.covered_fraction = self._raster.area_m2(self._inside & (counts > 0)) / self._area_m2

    def visibility(self) -> NDArray[np.float64] | None:
        """Return the share of the ground that at least one frame has seen, by cell; None without a known forest."""
        if self._occlusion is None:
            return None
        return np.asarray(1.0 - self._occlusion ** self._counts.astype(np.float64))

    def render(self) -> tuple[RasterPicture, ...]:
        """Return the pictures ``coverage`` and, where the forest is known, ``visibility``."""
        shares = {"coverage": np.minimum(self._counts / FULL_COUNT, 1.0), "visibility": self.visibility()}
        raster, (rows, columns) = self._raster, self._raster.shape
        return tuple(
            RasterPicture(
                kind=kind,
                png=encode_png(self._shade(share)),
                west_m=raster.west_m,
                south_m=raster.north_m - rows * raster.resolution_m,
                east_m=raster.west_m + columns * raster.resolution_m,
                north_m=raster.north_m,
            )
            for kind, share in shares.items()
            if share is not None
        )

    def _shade(self, share: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return shares from 0 to 1 as RGBA, transparent outside of the area and where nothing was seen."""
        bgr = cv2.applyColorMap((255.0 * share).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
        alpha = np.where(self._inside & (self._counts > 0), _ALPHA, np.uint8(0))
        return np.dstack((cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), alpha))


def add_footprints(
    coverage: CoverageMap, footprints: Sequence[Polygon], *, pictures: bool = True
) -> tuple[NDArray[np.uint16], tuple[RasterPicture, ...]]:
    """Return the counts of the map with the frames of a step, for :meth:`CoverageMap.set_counts`, and its pictures.

    Args:
        coverage: map without these frames.
        footprints: what they show of the ground.
        pictures: whether to render the map; otherwise there are none.
    """
    after = copy(coverage)
    after.add(footprints)
    return after.counts, after.render() if pictures else ()
