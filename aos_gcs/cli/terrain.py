"""``aos-gcs terrain``: elevation models of the ground."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aos_gcs.cli.planned import planned_places, read_settings
from aos_gcs.elevation.datum import VerticalDatum
from aos_gcs.elevation.report import ElevationReport, PlaceHeight, report_of
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import frame_scale_error
from aos_gcs.input_values import finite_numbers

if TYPE_CHECKING:
    from aos_gcs.elevation.model import ElevationModel
    from aos_gcs.planning.settings import MissionSettings, TerrainSettings
    from aos_gcs.planning.terrain.following import FollowedHeights

terrain = typer.Typer(no_args_is_help=True, add_completion=False)


@terrain.callback()
def _about() -> None:
    """Check elevation models of the ground."""


@terrain.command("check")
def check(
    files: Annotated[
        list[Path], typer.Argument(help="GeoTIFF or ASC files of one coordinate system and grid.", show_default=False)
    ],
    *,
    kind: Annotated[
        str,
        typer.Option(
            metavar="terrain|surface",
            help="Heights of the ground (DTM), or of the tops of trees and buildings (DSM). No file states it: see its "
            "provider's description.",
        ),
    ],
    datum: Annotated[
        VerticalDatum | None,
        typer.Option(help="Vertical datum of heights, where the files state none.", show_default=False),
    ] = None,
    crs: Annotated[
        str | None,
        typer.Option(metavar="EPSG:CODE", help="Coordinate system, where the files state none.", show_default=False),
    ] = None,
    geoid: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="PROJ's grid of the geoid EGM96, for heights above the ellipsoid. Without it, PROJ's folders are "
            "searched.",
        ),
    ] = None,
    at: Annotated[
        list[str] | None, typer.Option(metavar="LAT,LON", help="Place whose height is reported. May be repeated.")
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.toml", help="Configuration of a mission: heights at its launch site and over its search area."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check an elevation model: extent, resolution, datum, holes, and heights where a mission flies.

    Exit code 1 if a place, or part of the search area, has no height, there are no heights at all, or the altitude of a
    mission's origin is not that of the ground.
    """
    from aos_gcs.elevation.geoid import find_egm2008, find_geoid  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.elevation.model import SURFACE_WARNING, ElevationModel, ModelKind  # noqa: PLC0415
    from aos_gcs.planning.settings import TerrainSettings  # noqa: PLC0415
    from aos_gcs.planning.terrain.suspected_holes import holes_warning  # noqa: PLC0415

    if kind not in list(ModelKind):
        raise ConfigurationError(f"--kind must be terrain or surface, got {kind!r}.")
    model = ElevationModel(
        files, ModelKind(kind), datum=datum, crs=crs, geoid=find_geoid(geoid), egm2008=find_egm2008()
    )
    settings = None if plan is None else read_settings(plan)
    area, places = ((), ()) if settings is None else _planned(settings, f"{plan}")
    report = report_of(model, [*places, *(_place(text) for text in at or ())], area)
    model.close()
    followed, misfit = None, None if settings is None else _misfit(settings, report, model)
    if settings is not None and report.is_complete:
        named = TerrainSettings(
            files=tuple(map(str, files)),
            kind=ModelKind(kind),
            datum=datum,
            crs=crs,
            geoid=None if geoid is None else str(geoid),
        )
        followed = _followed(settings, named)
    found = asdict(report) | {"followed": None if followed is None else asdict(followed)}
    typer.echo(json.dumps(found) if as_json else "\n".join([*_lines(report), *_followed_lines(followed)]))
    if report.kind is ModelKind.SURFACE:
        typer.echo(SURFACE_WARNING, err=True)
    if report.holes is not None and report.holes.suspected is not None:
        typer.echo(holes_warning(report.holes.suspected), err=True)
    if misfit is not None:
        typer.echo(misfit, err=True)
    if misfit is not None or not report.is_complete:
        raise typer.Exit(1)


def _place(text: str) -> PlaceHeight:
    numbers = finite_numbers(text)
    if len(numbers) != 2 or not (abs(numbers[0]) <= 90.0 and abs(numbers[1]) <= 180.0):
        raise ConfigurationError(f"--at needs LATITUDE,LONGITUDE in degrees, got {text!r}.")
    return PlaceHeight(text, numbers[0], numbers[1])


def _planned(settings: MissionSettings, name: str) -> tuple[tuple[tuple[float, float], ...], tuple[PlaceHeight, ...]]:
    """Return the search area of a mission, latitudes and longitudes of its corners, and its launch site and corners."""
    site, corners = planned_places(settings, name)
    named = [("launch site", site)]
    named += [(f"corner {number}", corner) for number, corner in enumerate(corners, start=1)]
    places = tuple(PlaceHeight(name, place.latitude_deg, place.longitude_deg) for name, place in named)
    return tuple((corner.latitude_deg, corner.longitude_deg) for corner in corners), places


def _misfit(settings: MissionSettings, report: ElevationReport, model: ElevationModel) -> str | None:
    """Return what is wrong with the altitude of a mission's origin by the model, whose first place it is."""
    from aos_gcs.planning.terrain.check import origin_misfit  # noqa: PLC0415 - keeps the other commands' help fast

    height_m = report.places[0].height_m
    if settings.origin is None or height_m is None:
        return None
    return origin_misfit(settings.origin, height_m - settings.origin.altitude_amsl_m, model.geoid)


def _followed(settings: MissionSettings, terrain: TerrainSettings) -> FollowedHeights | None:
    """Return the heights of a mission's layers where they follow the ground, by the limits that it configures."""
    from aos_gcs.planning.terrain.following import followed_heights  # noqa: PLC0415 - keeps the other commands' help fast

    if settings.terrain is not None:
        terrain = replace(terrain, ceiling_above_ground_m=settings.terrain.ceiling_above_ground_m)
    return followed_heights(settings, terrain)


def _followed_lines(followed: FollowedHeights | None) -> list[str]:
    if followed is None:
        return []
    text = (
        f"layers that follow the ground (terrain.follow): above a surface of {followed.lowest_m:z.1f} to "
        f"{followed.highest_m:z.1f} m above the launch site, at most {followed.max_slope:.0%} steep, "
        f"{followed.least_above_ground_m:.1f} to {followed.most_above_ground_m:.1f} m above ground"
    )
    if not followed.is_below_ceiling:
        excess_m = followed.most_above_ground_m - followed.ceiling_m
        text += f", {excess_m:.1f} m beyond the ceiling of {followed.ceiling_m:g} m at {followed.most_at}"
    return [text]


def _lines(report: ElevationReport) -> list[str]:
    south, west, north, east = report.bounds_deg
    lines = [
        f"files: {', '.join(report.files)}",
        f"kind: {report.kind}",
        f"coordinate system: {report.crs}",
        f"vertical datum: {report.datum}",
        f"heights above mean sea level (EGM96): ± {report.datum_sigma_m:g} m by the change of datums",
        _geoid_line(report),
        f"extent: {south:.6f}, {west:.6f} to {north:.6f}, {east:.6f}",
        f"cells: {report.cells:,} of {report.cell_m[0]:.2f} x {report.cell_m[1]:.2f} m",
        _holes_line(report),
    ]
    if report.area is not None:
        area = report.area
        if area.lowest_m is None or area.highest_m is None:
            lines.append("search area: no heights")
        else:
            relief_m = area.highest_m - area.lowest_m
            lines.append(
                f"search area: {area.lowest_m:.1f} to {area.highest_m:.1f} m, {relief_m:.1f} m of relief; "
                f"{area.unknown} of {area.samples} places without a height"
            )
    for place in report.places:
        height = "no height: a hole, or beyond the model" if place.height_m is None else f"{place.height_m:.2f} m"
        lines.append(f"{place.name}: {height}")
    return lines


def _geoid_line(report: ElevationReport) -> str:
    if report.undulation_m is None:
        return "geoid: its height is not known here, no grid of it was found (Debian: proj-data; or --geoid FILE)"
    side = "above" if report.undulation_m >= 0.0 else "below"
    where = report.places[0].name if report.places else "the middle of the model"
    short = frame_scale_error(report.undulation_m) * 1e6
    return (
        f"geoid: {abs(report.undulation_m):.2f} m {side} the ellipsoid at {where}: lengths in a mission's frame are "
        f"{abs(short):.1f} millionths too {'short' if short >= 0.0 else 'long'}"
    )


def _holes_line(report: ElevationReport) -> str:
    if report.holes is None:
        return "holes: not counted, too many cells; --plan examines a search area"
    if report.holes.first_deg is None:
        return "holes: none"
    latitude_deg, longitude_deg = report.holes.first_deg
    share = report.holes.count / report.holes.cells
    return f"holes: {report.holes.count:,} cells ({share:.1%}), the first at {latitude_deg:.6f}, {longitude_deg:.6f}"
