"""``aos-gcs basemap``: a base map for the dashboard of files that teams have, or of a server's tiles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cli.basemap_download import (
    Area,
    Attribution,
    Plan,
    Rate,
    ServerOptions,
    TermsAllowCopies,
    Tiles,
    Zoom,
    download,
)
from aos_gcs.cli.output import progress
from aos_gcs.errors import ConfigurationError


def basemap(
    out: Annotated[
        Path, typer.Argument(help="PMTiles file to write; an existing one is replaced.", show_default=False)
    ],
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Orthophotos and maps: GeoTIFF in any coordinate system, GeoPackage with rasters, KMZ with ground "
            "overlays, of which later ones lie on top; or one MBTiles file.",
            show_default=False,
        ),
    ] = None,
    *,
    max_zoom: Annotated[
        int | None,
        typer.Option(
            help="Finest zoom; every zoom less is a quarter of the size. By default that of the files.", min=1, max=22
        ),
    ] = None,
    tiles: Tiles = None,
    terms_allow_copies: TermsAllowCopies = False,
    area: Area = None,
    plan: Plan = None,
    zoom: Zoom = None,
    attribution: Attribution = None,
    rate: Rate = None,
) -> None:
    """Make a base map that the dashboard shows without any network: name it as api.basemap in the configuration.

    Pictures become tiles of all zooms (WebP); tiles of an MBTiles file, pictures or vectors, and those of a server are
    copied as they are. An interrupted run leaves no incomplete map.
    """
    from aos_gcs.basemaps.making import make_basemap  # noqa: PLC0415 - heavy, only for this command

    server = ServerOptions(terms_allow_copies, area, plan, zoom, attribution, rate)
    if tiles is not None:
        if files or max_zoom is not None:
            raise ConfigurationError(
                "A map is made of files or by --tiles: leave the files out, and give --zoom instead of --max-zoom."
            )
        made = download(out, tiles, server)
    else:
        server.require_none()
        if not files:
            raise ConfigurationError("Name the files of which the map is to be made, or a server by --tiles.")
        made = make_basemap(out, files, lambda total: progress("Making tiles", total), max_zoom)
    zooms = "" if made.max_zoom is None else f", zooms {made.min_zoom} to {made.max_zoom}"
    typer.echo(f"{out}: {made.tiles:,} tiles{zooms}, {made.size_bytes / 1e6:,.1f} MB")
