"""``aos-gcs inspect``: what a mission folder tells."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import InputDataError


def inspect(
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Print one JSON object instead of text; with --truth of mission and score."),
    ] = False,
    steps: Annotated[bool, typer.Option("--steps", help="List every step.")] = False,
    truth: Annotated[
        Path | None,
        typer.Option(
            help="World file of the simulator (--world-file of aos-gcs sim and sim-camera): add how near the estimate "
            "has come to a person, and how much of one was seen.",
            dir_okay=False,
        ),
    ] = None,
    truth_report: Annotated[
        Path | None,
        typer.Option(help="Report of the same simulator (--report-file), for the true distances.", dir_okay=False),
    ] = None,
) -> None:
    """Show a recorded mission: finished, broken off, or still being flown.

    Shows its phases, vehicles, target estimate, notices, the operator's actions, outcome and files.
    """
    # Reading a mission takes NumPy and OpenCV, which the other commands' help should not wait for.
    from aos_gcs.cli.report import print_report  # noqa: PLC0415
    from aos_gcs.runtime.evaluation import score_mission  # noqa: PLC0415
    from aos_gcs.store.codec import encode  # noqa: PLC0415
    from aos_gcs.store.reader import MissionReader  # noqa: PLC0415
    from aos_gcs.store.summary import summarise  # noqa: PLC0415

    with MissionReader(mission_dir) as reader:
        summary = summarise(reader)
        snapshot = reader.last_snapshot()
    score = None
    if truth is not None:
        if snapshot is None:
            raise InputDataError(f"The mission in {mission_dir} has recorded no state that could be judged.")
        score = score_mission(snapshot, mission_dir, truth, truth_report)
    if as_json:
        content = encode(summary) if score is None else {"mission": encode(summary), "score": dataclasses.asdict(score)}
        typer.echo(json.dumps(content, indent=2, allow_nan=False))
        return
    print_report(summary, with_steps=steps)
    if score is not None:
        typer.echo("\nagainst the truth:\n" + "\n".join(f"  {line}" for line in score.lines()))
