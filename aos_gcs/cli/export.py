"""``aos-gcs export``: a recorded mission for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import ConfigurationError


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
) -> None:
    """Write a mission or a survey in the formats of other programs.

    The mission may be finished, interrupted or in flight.
    """
    # Frames are analysed with NumPy and OpenCV, which the other commands' help should not wait for.
    from aos_gcs.exports.files import check_apart, check_folder, check_writable, written_whole  # noqa: PLC0415
    from aos_gcs.runtime.adiat import write_adiat  # noqa: PLC0415
    from aos_gcs.runtime.finding_export import encode_findings  # noqa: PLC0415

    if adiat is None and findings is None:
        raise ConfigurationError("Nothing to write: give --adiat DIR, --findings FILE, or both.")
    if findings is not None:
        check_writable(findings)
        check_apart([findings], None, mission_dir.glob("*"))
        text = encode_findings(mission_dir, findings.suffix)
        with written_whole(findings) as file:
            file.write(text.encode())
        typer.echo(f"findings: {findings}")
    if adiat is not None:
        check_folder(adiat)
        written = write_adiat(mission_dir, adiat)
        typer.echo(f"{written.frames} frames, {written.integrals} integrals, {written.findings} findings: {adiat}")
