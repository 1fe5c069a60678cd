"""``aos-gcs export``: a recorded mission for other programs."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.notations import Notation
from aos_gcs.wall.model import TileName


def export(
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
    *,
    adiat: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Write a folder for ADIAT: geotagged frames and integrals, and the findings as areas of interest.",
            file_okay=False,
        ),
    ] = None,
    findings: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the findings: .geojson, .kml or .gpx.", dir_okay=False),
    ] = None,
    wall: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write a video (MP4) of all cameras and the integral side by side, with place and time burnt in.",
            dir_okay=False,
        ),
    ] = None,
    tiles: Annotated[
        str,
        typer.Option(metavar="NAMES", help="Tiles of the video in order, such as all.thermal,1.thermal. Default: all."),
    ] = "",
    notation: Annotated[Notation, typer.Option(help="Notation of the places in the video.")] = Notation.DECIMAL,
) -> None:
    """Write a mission or a survey in the formats of other programs.

    The mission may be finished, interrupted or in flight. Where one result cannot be made, none is written.
    """
    # Frames are analysed with NumPy and OpenCV, which the other commands' help should not wait for.
    from aos_gcs.exports.files import check_apart, check_new_folder, check_writable, written_whole  # noqa: PLC0415
    from aos_gcs.runtime.recorded.adiat import write_adiat  # noqa: PLC0415
    from aos_gcs.runtime.recorded.finding_export import encode_findings  # noqa: PLC0415

    if adiat is None and findings is None and wall is None:
        raise ConfigurationError("Nothing to write: give --adiat DIR, --findings FILE or --wall FILE.")
    chosen = _tiles(tiles, wall)
    files = [path for path in (findings, wall) if path is not None]
    for path in files:
        check_writable(path)
    check_apart(files, None, mission_dir.glob("*"))
    if adiat is not None:
        check_new_folder(adiat)
        if adiat.resolve() in {path.resolve().parent for path in files}:
            raise ConfigurationError(f"Cannot write {adiat}: another result lies in it; give each its own place.")
    said: list[str] = []
    with ExitStack() as results:  # all of them take their places when the last one is made, or none does
        if findings is not None:
            text = encode_findings(mission_dir, findings.suffix)
            results.enter_context(written_whole(findings)).write(text.encode())
            said.append(f"findings: {findings}")
        if wall is not None:
            from aos_gcs.runtime.wall.video import write_wall_video  # noqa: PLC0415 - heavy, only for videos

            video = results.enter_context(written_whole(wall))
            facts = write_wall_video(mission_dir, video, chosen, notation)
            missing = f", {facts.unreadable} pictures could not be read" if facts.unreadable else ""
            said.append(f"{len(facts.tiles)} tiles, {facts.duration_s:.0f} s{missing}: {wall}")
        if adiat is not None:
            made = write_adiat(mission_dir, adiat)
            said.append(f"{made.frames} frames, {made.integrals} integrals, {made.findings} findings: {adiat}")
    typer.echo("\n".join(said))


def _tiles(names: str, wall: Path | None) -> tuple[TileName, ...]:
    """Return the tiles that an option names."""
    if wall is None and names:
        raise ConfigurationError("--tiles chooses tiles of a video: give --wall FILE, too.")
    if wall is not None and wall.suffix.lower() != ".mp4":
        raise ConfigurationError(f"--wall writes MP4: name a file that ends in .mp4, not {wall.name}.")
    try:
        return tuple(TileName.parse(name.strip()) for name in names.split(",") if name.strip())
    except ValueError as error:
        raise ConfigurationError(f"--tiles: {error}.") from error
