"""Report on an elevation model, before plans rely on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.elevation.model import ElevationModel, ModelKind
from aos_gcs.elevation.suspects import Holes
from aos_gcs.height_rasters import unwrapped

MAX_COUNTED_CELLS = 250_000_000
"""Most cells that are looked through for holes: a minute or so."""

MAX_AREA_SAMPLES = 400
"""Samples along each axis of an area."""


@dataclass(frozen=True, slots=True)
class PlaceHeight:
    """A place whose height is asked for."""

    name: str
    latitude_deg: float
    longitude_deg: float
    height_m: float | None = None
    """Height above mean sea level; None where the model has a hole or ends."""


@dataclass(frozen=True, slots=True)
class AreaHeights:
    """Heights over an area."""

    samples: int
    unknown: int
    """Number of samples without a height."""
    lowest_m: float | None
    highest_m: float | None


@dataclass(frozen=True, slots=True)
class ElevationReport:
    """Properties of an elevation model."""

    files: tuple[str, ...]
    kind: ModelKind
    crs: str
    datum: str
    datum_sigma_m: float
    """Standard deviation that the change to mean sea level adds to the heights."""
    undulation_m: float | None
    """Height of the geoid above the ellipsoid at the first place, or else in the middle of the model; None without a
    grid of it."""
    bounds_deg: tuple[float, float, float, float]
    """Least latitude and longitude, and the greatest."""
    cells: int
    cell_m: tuple[float, float]
    holes: Holes | None
    """None: there are too many cells to look through."""
    places: tuple[PlaceHeight, ...]
    area: AreaHeights | None

    @property
    def is_complete(self) -> bool:
        """Whether all places and all of the area have heights, and there are heights at all."""
        is_empty = self.holes is not None and self.holes.count == self.holes.cells
        return (
            not is_empty
            and all(place.height_m is not None for place in self.places)
            and (self.area is None or self.area.unknown == 0)
        )


def report_of(
    model: ElevationModel, places: Sequence[PlaceHeight], area_deg: Sequence[tuple[float, float]] = ()
) -> ElevationReport:
    """Report on a model.

    Args:
        model: the model.
        places: places whose heights are asked for.
        area_deg: corners of an area that heights are looked at over, latitude and longitude.

    Raises:
        InputDataError: if a file cannot be read, or has impossible heights.
    """
    heights_m = model.heights_amsl_m(
        [place.latitude_deg for place in places], [place.longitude_deg for place in places]
    )
    return ElevationReport(
        files=tuple(str(path) for path in model.paths),
        kind=model.kind,
        crs=model.crs_name,
        datum=model.datum.name,
        datum_sigma_m=model.sigma_m,
        undulation_m=_undulation_m(model, places),
        bounds_deg=model.bounds_deg(),
        cells=model.cells,
        cell_m=model.cell_m,
        holes=model.holes(MAX_COUNTED_CELLS),
        places=tuple(
            PlaceHeight(
                place.name,
                place.latitude_deg,
                place.longitude_deg,
                float(height_m) if math.isfinite(height_m) else None,
            )
            for place, height_m in zip(places, heights_m, strict=True)
        ),
        area=_area_heights(model, np.array(area_deg)) if len(area_deg) else None,
    )


def _undulation_m(model: ElevationModel, places: Sequence[PlaceHeight]) -> float | None:
    if model.geoid is None:
        return None
    south, west, north, east = model.bounds_deg()
    at_deg = (places[0].latitude_deg, places[0].longitude_deg) if places else ((south + north) / 2, (west + east) / 2)
    undulation_m = float(model.geoid.undulation_m(*at_deg))
    return undulation_m if math.isfinite(undulation_m) else None


def _area_heights(model: ElevationModel, corners_deg: NDArray[np.float64]) -> AreaHeights:
    corners_deg[:, 1] = unwrapped(corners_deg[:, 1], corners_deg[0, 1])
    (south, west), (north, east) = corners_deg.min(axis=0), corners_deg.max(axis=0)
    latitude, longitude = np.meshgrid(
        np.linspace(south, north, MAX_AREA_SAMPLES), np.linspace(west, east, MAX_AREA_SAMPLES), indexing="ij"
    )
    # In samples, as OpenCV's polygons hold 32-bit integers.
    cells = (corners_deg - (south, west)) / (north - south, east - west) * (MAX_AREA_SAMPLES - 1)
    mask = np.zeros(latitude.shape, dtype=np.uint8)
    cv2.fillPoly(mask, [np.rint(cells[:, ::-1]).astype(np.int32)], 1)
    inside = mask.astype(bool)
    heights_m = model.heights_amsl_m(latitude[inside], longitude[inside])
    known_m = heights_m[np.isfinite(heights_m)]
    return AreaHeights(
        samples=len(heights_m),
        unknown=len(heights_m) - len(known_m),
        lowest_m=float(known_m.min()) if len(known_m) else None,
        highest_m=float(known_m.max()) if len(known_m) else None,
    )
