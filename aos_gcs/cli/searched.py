"""``aos-gcs searched``: what a mission has searched, and files of it."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from aos_gcs.groundmap.figures import GroundFigures, SegmentFigures


def searched(
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
    *,
    raster: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.tif",
            help="Write views and probabilities of detection as a cloud-optimised GeoTIFF (extra geo).",
            dir_okay=False,
        ),
    ] = None,
    gaps: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.geojson", help="Write the polygons of the search area below --below.", dir_okay=False
        ),
    ] = None,
    floor: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.tif",
            help="Write the integral of all frames on the ground, colours and temperatures, as a GeoTIFF (extra geo).",
            dir_okay=False,
        ),
    ] = None,
    below: Annotated[
        float, typer.Option(metavar="P", help="Probability of detection below which a place is a gap.")
    ] = 0.8,
    posture: Annotated[str, typer.Option(help="Posture for --gaps: standing, sitting or lying.")] = "standing",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")] = False,
) -> None:
    """Report what share of the search area was seen, and how likely a person there would have been noticed.

    The mission may be finished, interrupted or in flight. Former sorties of its operation count.
    """
    # Reading a mission takes NumPy and OpenCV, which the other commands' help should not wait for.
    from aos_gcs.errors import ConfigurationError  # noqa: PLC0415
    from aos_gcs.exports.files import check_apart, check_suffix, check_writable, written_whole  # noqa: PLC0415
    from aos_gcs.exports.ground_files import gaps_geojson, write_forest_floor, write_ground_raster  # noqa: PLC0415
    from aos_gcs.extras import load_extra  # noqa: PLC0415
    from aos_gcs.groundmap.detection import Posture  # noqa: PLC0415
    from aos_gcs.groundmap.ground_map import read_map  # noqa: PLC0415
    from aos_gcs.runtime.recorded.searched_ground import figures_of, read_searched_ground  # noqa: PLC0415
    from aos_gcs.store.schema import GROUND_NAME  # noqa: PLC0415

    if posture not in list(Posture):
        raise ConfigurationError(f"--posture must be one of {', '.join(Posture)}, got {posture!r}.")
    if not 0.0 < below <= 1.0:
        raise ConfigurationError(f"--below must be above 0 and at most 1, got {below:g}.")
    results = [path for path in (raster, gaps, floor) if path is not None]
    check_apart(results, None, mission_dir.rglob("*"))
    tiff = (".tif", ".tiff")
    for option, path, suffixes in (
        ("--raster", raster, tiff),
        ("--gaps", gaps, (".geojson", ".json")),
        ("--floor", floor, tiff),
    ):
        if path is not None:
            check_suffix(option, path, *suffixes)
            check_writable(path)
    if raster is not None or floor is not None:
        load_extra("rasterio", "geo", "Writing a GeoTIFF")
    ground = read_searched_ground(mission_dir)
    # What can be refused comes before the first file.
    text = "" if gaps is None else gaps_geojson(ground, Posture(posture), below)
    if floor is not None:
        write_forest_floor(floor, read_map(mission_dir / GROUND_NAME))
    if raster is not None:
        write_ground_raster(raster, ground)
    if gaps is not None:
        with written_whole(gaps) as file:
            file.write(text.encode())
    figures = figures_of(ground)
    if as_json:
        typer.echo(json.dumps(dataclasses.asdict(figures)))
        return
    for line in figure_lines(figures):
        typer.echo(line)
    for path in results:
        typer.echo(f"written: {path}")


def figure_lines(figures: GroundFigures) -> list[str]:
    """Return figures about the searched ground as lines of text."""
    seen = f"{figures.seen_fraction:.0%} of the area seen, {figures.mean_views:.1f} independent views on average"
    lines = [f"searched ground: {seen}, {figures.frames} frames"]
    if figures.left_out:
        lines.append(f"frames that are not on the map of searched ground: {figures.left_out}")
    shares = figures.detection
    if shares is not None:
        lines.append(
            f"mean probability of detection: standing {shares.standing:.0%}, sitting {shares.sitting:.0%}, "
            f"lying {shares.lying:.0%}"
        )
    if figures.success is not None:
        lines.append(f"probability of success by the prior: {figures.success:.0%}")
    return [*lines, *map(_segment_line, figures.segments)]


def _segment_line(segment: SegmentFigures) -> str:
    """Return the figures of a segment, all flights so far, as a line of text."""
    parts = [f"{segment.seen_fraction:.0%} of {segment.area_m2 / 1e4:.2f} ha seen"]
    if segment.detection is not None:
        parts.append(f"probability of detection (standing) {segment.detection:.0%}")
    if segment.probability is not None:
        parts.append(f"probability of area {segment.probability:.0%}")
    if segment.success is not None:
        parts.append(f"of success {segment.success:.0%}")
    return f"segment {segment.name}: {', '.join(parts)}"
