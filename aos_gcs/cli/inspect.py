"""``aos-gcs inspect``: what a mission folder tells."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer


def inspect(
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")] = False,
    steps: Annotated[bool, typer.Option("--steps", help="List every step.")] = False,
) -> None:
    """Show a recorded mission: finished, broken off, or still being flown.

    Shows its phases, vehicles, target estimate, notices, the operator's actions, outcome and files.
    """
    # Reading a mission takes NumPy and OpenCV, which the other commands' help should not wait for.
    from aos_gcs.cli.report import print_report  # noqa: PLC0415
    from aos_gcs.store.codec import encode  # noqa: PLC0415
    from aos_gcs.store.reader import MissionReader  # noqa: PLC0415
    from aos_gcs.store.summary import summarise  # noqa: PLC0415

    with MissionReader(mission_dir) as reader:
        summary = summarise(reader)
    if as_json:
        typer.echo(json.dumps(encode(summary), indent=2, allow_nan=False))
    else:
        print_report(summary, with_steps=steps)
