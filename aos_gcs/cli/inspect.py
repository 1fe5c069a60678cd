"""``aos-gcs inspect``: report on a recorded mission."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import InputDataError


def inspect(
    mission_dir: Annotated[Path, typer.Argument(help="Folder of one mission, which holds mission.sqlite.")],
    *,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="Print one JSON object instead of text; with --truth, one with mission and score."),
    ] = False,
    steps: Annotated[bool, typer.Option("--steps", help="List every step.")] = False,
    truth: Annotated[
        Path | None,
        typer.Option(
            help="World file of the simulator (--world-file of aos-gcs sim and sim-camera): also report which claims "
            "were right, their position error, and how much of a person was visible.",
            dir_okay=False,
        ),
    ] = None,
    audit: Annotated[
        bool,
        typer.Option(
            "--audit",
            help="Verify the audit chain instead: who did what when. Prints the digest, or the first entry that was "
            "changed. Exit status 0: intact; 1: changed.",
        ),
    ] = False,
    truth_report: Annotated[
        Path | None,
        typer.Option(help="Report of the same simulator (--report-file), for the true distances.", dir_okay=False),
    ] = None,
) -> None:
    """Show a recorded mission: finished, interrupted, or still in flight.

    Shows its phases, vehicles, target estimate, notices, the operator's actions, outcome and files.
    """
    # Reading a mission takes NumPy and OpenCV, which the other commands' help should not wait for.
    from aos_gcs.cli.display.report import print_report  # noqa: PLC0415
    from aos_gcs.runtime.evaluation import score_mission  # noqa: PLC0415
    from aos_gcs.store.codec import encode  # noqa: PLC0415
    from aos_gcs.store.reader import MissionReader  # noqa: PLC0415
    from aos_gcs.store.summary import summarise  # noqa: PLC0415

    if audit:
        _verify_audit(mission_dir, as_json=as_json)
        return
    with MissionReader(mission_dir) as reader:
        summary = summarise(reader)
        snapshot = reader.last_snapshot()
    score = None
    if truth is not None:
        if snapshot is None:
            raise InputDataError(f"The mission in {mission_dir} contains no recorded state to compare with the truth.")
        score = score_mission(snapshot, mission_dir, truth, truth_report)
    if as_json:
        content = encode(summary) if score is None else {"mission": encode(summary), "score": dataclasses.asdict(score)}
        typer.echo(json.dumps(content, indent=2, allow_nan=False))
        return
    print_report(summary, with_steps=steps)
    if score is not None:
        typer.echo("\ncompared with the truth:\n" + "\n".join(f"  {line}" for line in score.lines()))


def _verify_audit(mission_dir: Path, *, as_json: bool) -> None:
    from aos_gcs.store.audit import verify_audit  # noqa: PLC0415 - heavy, only for this option

    report = verify_audit(mission_dir)
    if as_json:
        typer.echo(json.dumps(dataclasses.asdict(report), indent=2))
    elif report.fault is None:
        typer.echo(f"intact: {len(report.entries)} entries, digest {report.digest}")
    else:
        typer.echo(f"changed: {report.fault}; the {len(report.entries)} entries before it are intact")
    if report.fault is not None:
        raise typer.Exit(1)
