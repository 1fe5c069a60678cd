"""``aos-gcs lab detectability``: calibrate the probability of detection on simulated persons."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cli.lab.effectiveness import parse_densities
from aos_gcs.cluster import check_jobs
from aos_gcs.process import use_one_opencv_thread


def detectability(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder that receives, or already holds, the results.")],
    *,
    forests: Annotated[int, typer.Option(help="Forests of each density.")] = 12,
    densities: Annotated[str, typer.Option(help="Trees per hectare, separated by commas.")] = "150,300,500",
    seed: Annotated[int, typer.Option(help="Random seed of the first forest; the others count up from it.")] = 73000,
    places: Annotated[int, typer.Option(help="Places of persons in each forest.")] = 2,
    views: Annotated[int, typer.Option(help="Frames of each person.")] = 12,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as one JSON object.")] = False,
    jobs: Annotated[int, typer.Option(help="Number of processes on this machine.", callback=check_jobs)] = 1,
) -> None:
    """Fit the law of detection to persons in simulated forests, and report how far it is from what was observed.

    Standing, sitting and lying persons are rendered from many directions and examined as missions examine their
    frames. The same command goes on where it was stopped. See docs/ground-map.md.
    """
    use_one_opencv_thread()
    from dataclasses import asdict  # noqa: PLC0415 - keeps the other commands' help fast
    from functools import partial  # noqa: PLC0415
    from importlib.metadata import version  # noqa: PLC0415

    from aos_gcs.cli.output import progress  # noqa: PLC0415
    from aos_gcs.groundmap.directions import USUAL_STEP  # noqa: PLC0415
    from aos_gcs.lab.detectability.report import as_markdown, summarise  # noqa: PLC0415
    from aos_gcs.lab.detectability.store import DetectabilityFolder  # noqa: PLC0415
    from aos_gcs.lab.detectability.study import DetectabilitySettings, forest_keys, watch_forest  # noqa: PLC0415
    from aos_gcs.lab.workers import compute_each  # noqa: PLC0415
    from aos_gcs.planning.settings import DetectionSettings  # noqa: PLC0415

    settings = DetectabilitySettings(places, views, version("aos-gcs"))
    keys = forest_keys(parse_densities(densities), forests, seed)
    folder = DetectabilityFolder(out, settings)
    known = {forest.key for forest in folder.forests()}
    missing = tuple(key for key in keys if key not in known)
    with progress("Forests", len(missing)) as advance:
        for _, forest in compute_each(partial(watch_forest, settings), missing, jobs=jobs):
            folder.append(forest)
            advance(1)
    wanted = [forest for forest in folder.forests() if forest.key in set(keys)]
    figures = summarise(wanted, DetectionSettings().threshold_m2, USUAL_STEP)
    typer.echo(json.dumps(asdict(figures)) if as_json else as_markdown(figures), nl=as_json)
