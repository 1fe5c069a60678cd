"""Searched ground of recorded missions: its figures, and files of it."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.exports.ground_files import SearchedGround, gaps_geojson, write_ground_raster
from aos_gcs.groundmap.detection import Posture
from aos_gcs.groundmap.figures import GroundFigures, ground_figures, view_raster
from aos_gcs.groundmap.ground_map import HEADER_NAME, read_map
from aos_gcs.groundmap.work import SearchedArea, with_parts
from aos_gcs.mission.viewing import GroundFile
from aos_gcs.prior.file import prior_over
from aos_gcs.prior.segments import segments_about
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.schema import GROUND_NAME

_log = logging.getLogger(__name__)
_T = TypeVar("_T")


def read_searched_ground(folder: Path) -> SearchedGround:
    """Return the searched ground of a mission folder, also of a mission in flight: as it was written last.

    Views are as old as they were at the latest one of the map.

    Raises:
        InputDataError: there is none, or the record is damaged; the text names the folder.
    """
    with MissionReader(folder) as reader:
        search = reader.search() if reader.has_decisions else None
    ground = folder / GROUND_NAME
    if search is None or not (ground / HEADER_NAME).exists():
        raise InputDataError(
            f"{folder} holds no map of searched ground: nothing was searched yet, or it is the record of an older "
            "version or a survey."
        )
    stored, settings = read_map(ground), search.settings
    origin, names = stored.header.origin, settings.search
    return SearchedGround(
        raster=view_raster(stored.views_since(names.views_since_s(stored.latest_s)), settings.area_enu_m),
        origin=stored.header.origin,
        area_enu_m=settings.area_enu_m,
        occlusion=None if settings.forest is None else settings.forest.occlusion,
        frames=stored.header.frames,
        prior=_if_there(lambda: names.prior and prior_over(names.prior, origin, settings.area_enu_m)),
        segments=_if_there(lambda: names.segments and segments_about(names.segments, origin)) or (),
    )


def _if_there(read: Callable[[], _T | str | None]) -> _T | None:
    """Return what is read from a file that the mission was flown with; None where it is gone, or was changed since."""
    try:
        found = read()
    except (ConfigurationError, InputDataError) as error:
        _log.warning("left out of the figures: %s", error)
        return None
    return None if isinstance(found, str) else found


def figures_of(ground: SearchedGround) -> GroundFigures:
    """Return the figures about the search area."""
    area = SearchedArea(ground.area_enu_m, ground.occlusion, ground.prior, ground.segments)
    figures = ground_figures(ground.raster, ground.area_enu_m, ground.occlusion, ground.frames, 0)
    return with_parts(figures, ground.raster, area)


def make_ground_file(folder: Path, kind: GroundFile, posture: Posture, below: float) -> bytes:
    """Return a file of the searched ground.

    Args:
        folder: mission folder.
        kind: kind of the file.
        posture: posture of the person, for gaps.
        below: probability of detection below which a place is a gap.

    Raises:
        ConfigurationError: a library is not installed, the forest is not described, or ``below`` is out of its range.
        InputDataError: there is no map, or the record is damaged.
    """
    ground = read_searched_ground(folder)
    if kind is GroundFile.GAPS:
        return gaps_geojson(ground, posture, below).encode()
    with tempfile.TemporaryDirectory() as temporary:
        path = Path(temporary) / "ground.tif"
        write_ground_raster(path, ground)
        return path.read_bytes()
