"""Copies of a tile server's tiles for ``aos-gcs basemap``: options, and what is said before the first request."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from aos_gcs.cli.output import progress
from aos_gcs.cli.planned import planned_places, read_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.input_values import finite_numbers

if TYPE_CHECKING:
    from aos_gcs.basemaps.making import BasemapReport

PANEL: Final = "Tile servers"
DEFAULT_RATE_PER_S: Final = 4.0
MARGIN_M: Final = 500.0
"""Width of the map around a planned area."""
_M_PER_DEG: Final = 111_195.0

Tiles = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Copy the tiles of a server instead: its address with {z}, {x}, and {y} or, for rows that count from the "
        "south, {-y}.",
        rich_help_panel=PANEL,
    ),
]
TermsAllowCopies = Annotated[
    bool,
    typer.Option(
        "--terms-allow-copies",
        help="State that you have read the terms of the server, and that they allow copies of its tiles for use "
        "without a network. Required with --tiles.",
        rich_help_panel=PANEL,
    ),
]
Area = Annotated[
    str | None,
    typer.Option(metavar="W,S,E,N", help="Area in degrees of longitude and latitude.", rich_help_panel=PANEL),
]
Plan = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.toml",
        help="Configuration of a mission, instead of --area: its launch site and search area, and "
        f"{MARGIN_M:.0f} m around.",
        rich_help_panel=PANEL,
    ),
]
Zoom = Annotated[
    str | None, typer.Option(metavar="MIN-MAX", help="Zooms of the tiles, such as 12-17.", rich_help_panel=PANEL)
]
Attribution = Annotated[
    str | None,
    typer.Option(metavar="TEXT", help="Text that the server's terms ask for, shown on the map.", rich_help_panel=PANEL),
]
Rate = Annotated[
    float | None,
    typer.Option(
        metavar="N",
        help=f"Greatest number of requests per second. By default {DEFAULT_RATE_PER_S:g}.",
        min=0.1,
        max=10.0,
        rich_help_panel=PANEL,
    ),
]


@dataclass(frozen=True, slots=True)
class ServerOptions:
    """Options that go with ``--tiles``, as they were given; names are those of the command line."""

    terms_allow_copies: bool
    area: str | None
    plan: Path | None
    zoom: str | None
    attribution: str | None
    rate: float | None

    def require_none(self) -> None:
        """Refuse all options.

        Raises:
            ConfigurationError: one is given.
        """
        for field in fields(self):
            if getattr(self, field.name):
                option = field.name.replace("_", "-")
                raise ConfigurationError(f"--{option} is for the tiles of a server: add --tiles, or leave it out.")


def download(out: Path, address: str, options: ServerOptions) -> BasemapReport:
    """Copy tiles, when it has been said how many, from where and for how long.

    Args:
        out: map to make.
        address: template of the server's addresses.
        options: what goes with it.

    Raises:
        ConfigurationError: an option is missing or cannot be used; nothing was asked of the server.
        AosError: see :func:`~aos_gcs.basemaps.downloading.download_basemap`.
    """
    from aos_gcs.basemaps.downloading import TileArea, download_basemap  # noqa: PLC0415 - heavy
    from aos_gcs.basemaps.tiles.addresses import TileTemplate  # noqa: PLC0415
    from aos_gcs.basemaps.tiles.requests import Pace  # noqa: PLC0415
    from aos_gcs.basemaps.tiles.store import store_of  # noqa: PLC0415

    template = TileTemplate.parsed(address)
    if not options.terms_allow_copies:
        raise ConfigurationError(
            f"Whether tiles may be copied is up to the terms of {template.host}, and many servers forbid it: read "
            "them, and add --terms-allow-copies if they allow it."
        )
    area = TileArea.checked(_degrees(options), *_zooms(options.zoom))
    per_s = options.rate or DEFAULT_RATE_PER_S
    typer.echo(
        f"{area.count:,} tiles of zooms {area.min_zoom} to {area.max_zoom} from {template.host}, at most {per_s:g} per "
        f"second: {_duration(area.count / per_s)} or more. Until the map is complete they are kept in "
        f"{store_of(out)}; if this is interrupted, the same command goes on.",
        err=True,
    )
    return download_basemap(
        out,
        template,
        area,
        options.attribution or "",
        pace=Pace(per_s),
        progress=lambda total: progress("Copying tiles", total),
    )


def _degrees(options: ServerOptions) -> tuple[float, float, float, float]:
    """Return western longitude, southern latitude, eastern longitude and northern latitude of the area."""
    if (options.area is None) == (options.plan is None):
        raise ConfigurationError("--tiles needs either --area W,S,E,N or --plan FILE.toml.")
    if options.plan is not None:
        return _around(options.plan)
    match finite_numbers(options.area or ""):
        case [west, south, east, north]:
            return west, south, east, north
    raise ConfigurationError(f"--area needs west,south,east,north in degrees, got {options.area!r}.")


def _around(plan: Path) -> tuple[float, float, float, float]:
    site, corners = planned_places(read_settings(plan), f"{plan}")
    places = [site, *corners]
    latitudes, longitudes = [one.latitude_deg for one in places], [one.longitude_deg for one in places]
    high = MARGIN_M / _M_PER_DEG
    wide = high / math.cos(math.radians(max(map(abs, latitudes))))
    return min(longitudes) - wide, min(latitudes) - high, max(longitudes) + wide, max(latitudes) + high


def _zooms(text: str | None) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{1,2})-(\d{1,2})", text or "")
    if found is None:
        raise ConfigurationError(
            "--tiles needs --zoom MIN-MAX, such as 12-17." if text is None else f"--zoom needs MIN-MAX, got {text!r}."
        )
    return int(found[1]), int(found[2])


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"
