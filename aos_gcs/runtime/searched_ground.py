"""Searched ground of recorded missions: its figures, and files of it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from aos_gcs.errors import InputDataError
from aos_gcs.exports.ground_files import SearchedGround, gaps_geojson, write_ground_raster
from aos_gcs.groundmap.detection import Posture
from aos_gcs.groundmap.figures import GroundFigures, ground_figures, view_raster
from aos_gcs.groundmap.ground_map import HEADER_NAME, read_map
from aos_gcs.mission.viewing import GroundFile
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.schema import GROUND_NAME


def read_searched_ground(folder: Path) -> SearchedGround:
    """Return the searched ground of a mission folder, also of a mission in flight: as it was written last.

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
    return SearchedGround(
        raster=view_raster(stored.views, settings.area_enu_m),
        origin=stored.header.origin,
        area_enu_m=settings.area_enu_m,
        occlusion=None if settings.forest is None else settings.forest.occlusion,
        frames=stored.header.frames,
    )


def figures_of(ground: SearchedGround) -> GroundFigures:
    """Return the figures about the search area."""
    return ground_figures(ground.raster, ground.area_enu_m, ground.occlusion, ground.frames, 0)


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
