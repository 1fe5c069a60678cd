"""Height of the geoid above the WGS84 ellipsoid, from the grid files of PROJ."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra

GRID_NAMES = ("egm96_15.gtx", "us_nga_egm96_15.tif")
"""Names of the grid of EGM96 in Debian's proj-data and in PROJ's own collection."""

EGM2008_GRID_NAMES = ("us_nga_egm08_25.tif", "egm08_25.gtx")
"""Names of the grid of EGM2008, which Debian does not have."""

_SYSTEM_FOLDERS = (Path("/usr/share/proj"), Path("/usr/local/share/proj"), Path("/opt/homebrew/share/proj"))


class Geoid:
    """A geoid, by its heights above the ellipsoid."""

    def __init__(self, grid: Path) -> None:
        """Open a grid file of PROJ (``.gtx``, ``.tif``).

        Raises:
            InputDataError: if it is none.
            ConfigurationError: if pyproj is not installed.
        """
        pyproj: Any = load_extra("pyproj", "geo", "The height of the geoid")
        self.grid = grid
        pipeline = (
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
            f'+step +proj=vgridshift +grids="{grid}" +multiplier=1 '
            "+step +proj=unitconvert +xy_in=rad +xy_out=deg"
        )
        try:
            self._shift = pyproj.Transformer.from_pipeline(pipeline)
        except pyproj.exceptions.ProjError as error:
            raise InputDataError(f"The geoid {grid} is not a grid file that PROJ can read.") from error

    def undulation_m(self, latitude_deg: ArrayLike, longitude_deg: ArrayLike) -> NDArray[np.float64]:
        """Return the heights of the geoid above the ellipsoid; NaN outside of the grid."""
        latitude, longitude = np.broadcast_arrays(
            np.asarray(latitude_deg, dtype=np.float64), np.asarray(longitude_deg, dtype=np.float64)
        )
        _, _, heights_m = self._shift.transform(longitude, latitude, np.zeros(latitude.shape))
        return np.where(np.isfinite(heights_m), heights_m, np.nan)


def find_geoid(grid: Path | None = None) -> Geoid | None:
    """Return the geoid EGM96 of a file, or of the first known one that PROJ's folders hold; None if there is none.

    Raises:
        ConfigurationError: if the file does not exist, or pyproj is not installed.
        InputDataError: if it cannot be read.
    """
    if grid is not None:
        if not grid.is_file():
            raise ConfigurationError(f"The geoid {grid} does not exist; check the path.")
        return Geoid(grid)
    return _first_of(GRID_NAMES)


def find_egm2008() -> Geoid | None:
    """Return the geoid EGM2008 by the grid that PROJ's folders hold; None if there is none.

    Raises:
        ConfigurationError: if pyproj is not installed.
        InputDataError: if it cannot be read.
    """
    return _first_of(EGM2008_GRID_NAMES)


def _first_of(names: Sequence[str]) -> Geoid | None:
    datadir: Any = load_extra("pyproj.datadir", "geo", "The height of the geoid")
    folders = [*(Path(part) for part in datadir.get_data_dir().split(":")), Path(datadir.get_user_data_dir())]
    for folder in [*folders, *_SYSTEM_FOLDERS]:
        for name in names:
            if (folder / name).is_file():
                return Geoid(folder / name)
    return None
