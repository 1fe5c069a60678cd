"""Make a base map of files, by what they are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.basemaps.archive import tile_archive
from aos_gcs.basemaps.kmz import kmz_sources
from aos_gcs.basemaps.mbtiles import open_mbtiles
from aos_gcs.basemaps.pyramid import KIND, Advance, Pyramid, TileSource
from aos_gcs.basemaps.rasters import raster_sources
from aos_gcs.errors import ConfigurationError
from aos_gcs.input_values import require_file

Progress = Callable[[int], AbstractContextManager[Advance]]
"""Shows how far a number of tiles is."""

ENDING = ".pmtiles"
MBTILES_ENDING = ".mbtiles"
_KMZ_ENDING = ".kmz"


@dataclass(frozen=True, slots=True)
class BasemapReport:
    """What a base map holds."""

    tiles: int
    min_zoom: int | None
    """None for tiles that were copied."""
    max_zoom: int | None
    size_bytes: int


def make_basemap(out: Path, files: Sequence[Path], progress: Progress, max_zoom: int | None = None) -> BasemapReport:
    """Make a PMTiles archive of map files.

    Args:
        out: archive; an existing one is replaced when the new one is complete.
        files: GeoTIFF, GeoPackage and KMZ files, of which later ones lie on top; or a single MBTiles file.
        progress: shows the tiles that are done.
        max_zoom: finest zoom; None: by the resolution of the files.

    Raises:
        ConfigurationError: the files do not go together, a library is missing, or the archive cannot be written.
        InputDataError: a file cannot be used.
    """
    require_ending(out)
    for file in files:
        require_file(file, str(file))
    if any(file.suffix.lower() == MBTILES_ENDING for file in files):
        return _copy(out, files, progress, max_zoom)
    with ExitStack() as stack:
        sources: list[TileSource] = []
        attributions: list[str] = []
        for file in files:
            if file.suffix.lower() == _KMZ_ENDING:
                sources += kmz_sources(file)
            else:
                rasters = stack.enter_context(raster_sources(file))
                sources += rasters
                attributions += [raster.attribution for raster in rasters]
        pyramid = Pyramid(sources, max_zoom)
        archive = stack.enter_context(tile_archive(out))
        with progress(pyramid.count) as advance:
            pyramid.write(archive, advance)
        archive.finish(KIND, pyramid.box, described(out, attributions))
    return BasemapReport(archive.tiles, pyramid.min_zoom, pyramid.max_zoom, out.stat().st_size)


def require_ending(out: Path) -> None:
    """Refuse a name that is not that of a PMTiles file.

    Raises:
        ConfigurationError: the name ends otherwise.
    """
    if out.suffix.lower() != ENDING:
        raise ConfigurationError(f"{out}: a base map is a PMTiles file: let its name end with {ENDING}.")


def _copy(out: Path, files: Sequence[Path], progress: Progress, max_zoom: int | None) -> BasemapReport:
    if len(files) > 1 or max_zoom is not None:
        raise ConfigurationError(
            f"The tiles of an MBTiles file are copied as they are: give it alone, without --max-zoom, not with "
            f"{len(files) - 1} other files."
        )
    with open_mbtiles(files[0]) as tiles, tile_archive(out) as archive, progress(tiles.count) as advance:
        tiles.copy_to(archive, advance)
    return BasemapReport(archive.tiles, None, None, out.stat().st_size)


def described(out: Path, attributions: Sequence[str]) -> dict[str, object]:
    """Return what an archive says of itself: the name of its file, and all attributions, each once."""
    metadata: dict[str, object] = {"name": out.stem, "type": "baselayer"}
    said = "; ".join(dict.fromkeys(one for one in attributions if one))
    return metadata | ({"attribution": said} if said else {})
