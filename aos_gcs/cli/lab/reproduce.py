"""``aos-gcs lab reproduce``: the results of docs/results.md, from nothing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aos_gcs.cluster import check_jobs

if TYPE_CHECKING:
    from aos_gcs.lab.results import ResultFolder

_DENSITIES = (300.0, 400.0, 500.0)
_WORLDS, _VIEWS = 60, 40


def reproduce(
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the runs; an interrupted call continues.")],
    document: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Markdown file to write or renew (default: DIR/results.md).")
    ] = None,
    initialisations: Annotated[int, typer.Option(help="Number of drawn initialisations per study.", min=3)] = 100,
    jobs: Annotated[int, typer.Option(help="Number of processes on this machine.", callback=check_jobs)] = 1,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Address of a Dask scheduler, such as tcp://10.0.0.1:8786.")
    ] = None,
) -> None:
    """Run the studies behind docs/results.md, and write that document with its figures.

    This takes hours; after an interruption the same command continues.
    """
    from aos_gcs.cli.output import progress  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.exports.files import check_folder  # noqa: PLC0415
    from aos_gcs.lab.calibration import single_view_visibility  # noqa: PLC0415
    from aos_gcs.lab.document import document_frame, write_document  # noqa: PLC0415
    from aos_gcs.lab.scenario import parse_scenario  # noqa: PLC0415
    from aos_gcs.lab.studies import HELD_OUT_SEED, run_studies  # noqa: PLC0415
    from aos_gcs.lab.workers import compute  # noqa: PLC0415

    def compute_study(results: ResultFolder, title: str) -> None:
        with progress(title, len(results.missing())) as advance:
            compute(results, advance, jobs=jobs, scheduler=scheduler)

    # Before hours of work: what cannot be written or renewed is refused at once.
    check_folder(out)
    path = document or out / "results.md"
    frame = document_frame(path)
    results = run_studies(out, initialisations, compute_study)
    calibration = {}
    for density in _DENSITIES:
        scenario = parse_scenario({"trees_per_ha": density})
        with progress(f"Single views at {density:g} trees/ha", _WORLDS) as advance:
            calibration[density] = single_view_visibility(
                scenario, worlds=_WORLDS, views=_VIEWS, seed=HELD_OUT_SEED, advance=advance
            )
    write_document(results, calibration, path, frame)
    typer.echo(path)
