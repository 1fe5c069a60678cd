"""``aos-gcs report``: the hand-over of a recorded mission on paper, and its flight log."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.notations import Notation
from aos_gcs.handover.model import HandoverOptions, Paper


def report(
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
    *,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.pdf", help="Write the hand-over as a PDF.", dir_okay=False)
    ] = None,
    flights: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Write the flight log: one line per flight.", dir_okay=False),
    ] = None,
    paper: Annotated[Paper, typer.Option(help="Size of the paper.")] = Paper.A4,
    notation: Annotated[Notation, typer.Option(help="Notation of positions.")] = Notation.DECIMAL,
    time_zone: Annotated[
        str, typer.Option(metavar="NAME", help="Time zone of all times in the PDF, such as Europe/Vienna.")
    ] = "UTC",
) -> None:
    """Print the hand-over of a mission: summary, map, findings with pictures, assignment, flights and log.

    The mission may be finished, interrupted or in flight. The PDF needs the extra report.
    """
    # What makes the report takes NumPy and OpenCV, which the other commands' help should not wait for.
    from aos_gcs.exports.files import check_apart, check_suffix, check_writable, written_whole  # noqa: PLC0415
    from aos_gcs.runtime.recorded.handover import check_printing, make_flight_log, make_handover  # noqa: PLC0415

    options = HandoverOptions(paper, notation, time_zone)
    results = [path for path in (out, flights) if path is not None]
    if not results:
        raise ConfigurationError("Nothing to write: give --out FILE.pdf, --flights FILE.csv, or both.")
    check_apart(results, None, mission_dir.glob("*"))
    for option, path, suffix in (("--out", out, ".pdf"), ("--flights", flights, ".csv")):
        if path is not None:
            check_suffix(option, path, suffix)
            check_writable(path)
    if out is not None:
        check_printing(options)
    table = None if flights is None else make_flight_log(mission_dir)
    if out is not None:
        pdf = make_handover(mission_dir, options, datetime.now(UTC).timestamp())
        with written_whole(out) as document:
            document.write(pdf)
        typer.echo(f"hand-over: {out}")
    if flights is not None and table is not None:
        with written_whole(flights) as log:
            log.write(table.encode())
        typer.echo(f"flight log: {flights}")
