"""``aos-gcs inspect``: report on a recorded mission."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aos_gcs.errors import ConfigurationError, InputDataError

if TYPE_CHECKING:
    from aos_gcs.store.audit import AuditEntry, AuditReport


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
    audit_digest: Annotated[
        str | None,
        typer.Option(
            metavar="HEX",
            help="Digest that was noted elsewhere, as on the paper of a hand-over, or its first 16 digits at least: "
            "verify the audit chain, and that one of its entries has this digest. Exit status 1 also where none has.",
        ),
    ] = None,
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
    from aos_gcs.runtime.simulated.evaluation import score_mission  # noqa: PLC0415
    from aos_gcs.store.codec import encode  # noqa: PLC0415
    from aos_gcs.store.reader import MissionReader  # noqa: PLC0415
    from aos_gcs.store.summary import summarise  # noqa: PLC0415

    verifies = audit or audit_digest is not None
    if verifies and (steps or truth is not None or truth_report is not None):
        raise ConfigurationError("--audit verifies the chain and shows nothing else: leave --steps and --truth out.")
    if truth_report is not None and truth is None:
        raise ConfigurationError("--truth-report adds to --truth: give the world file of the same simulator, too.")
    if verifies:
        _verify_audit(mission_dir, audit_digest, as_json=as_json)
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


def _verify_audit(mission_dir: Path, noted: str | None, *, as_json: bool) -> None:
    from aos_gcs.store.audit import noted_entry, parse_digest, verify_audit  # noqa: PLC0415 - heavy, only for this

    digits = None if noted is None else parse_digest(noted)
    report = verify_audit(mission_dir)
    entry = None if digits is None else noted_entry(report, digits)
    if as_json:
        told = dataclasses.asdict(report)
        if digits is not None:
            told["noted"] = {"digest": digits, "entry": None if entry is None else entry.entry}
        typer.echo(json.dumps(told, indent=2))
    else:
        if report.fault is None:
            typer.echo(f"intact: {len(report.entries)} entries, digest {report.digest}")
        else:
            typer.echo(f"changed: {report.fault}; the {len(report.entries)} entries before it are intact")
        if digits is not None:
            typer.echo(_noted_text(report, entry))
    if report.fault is not None or (digits is not None and entry is None):
        raise typer.Exit(1)


def _noted_text(report: AuditReport, entry: AuditEntry | None) -> str:
    from aos_gcs.store.audit import utc_text  # noqa: PLC0415 - heavy, only for this

    if entry is None:
        return (
            f"noted digest: none of the {len(report.entries)} entries has it. Check its digits and the folder; if both "
            "are right, this is not the record of which it was noted, or its chain was computed anew"
        )
    when = "" if entry.utc_s is None else f" of {utc_text(entry.utc_s)}"
    later = len(report.entries) - entry.entry
    return (
        f"noted digest: that of entry {entry.entry} ({entry.source} {entry.row}){when}; the entries up to it are the "
        f"same as when it was noted, {later} came later"
    )
