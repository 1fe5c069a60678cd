"""The text that ``aos-gcs inspect`` prints: tables, drawn with lines on a terminal and plain otherwise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import UTC, datetime

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from aos_gcs.cli.searched import figure_lines
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.findings import KIND_NAMES, Finding, FindingStatus
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord, VehicleSnapshot
from aos_gcs.store.summary import FrameCount, MissionSummary

Row = Sequence[str]

PLAIN_WIDTH = 200
"""Characters per line where there is no terminal to fit into."""


def print_report(summary: MissionSummary, *, with_steps: bool) -> None:
    """Print a mission to standard output."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = PLAIN_WIDTH
    console.print(Text(_headline(summary)))
    for line in _facts(summary):
        console.print(Text(line))
    spans = [(span.phase, f"{span.start_s:.0f}", f"{span.end_s:.0f}") for span in summary.phases]
    _print_table(console, "Phases", ("phase", "from s", "to s"), spans)
    if with_steps:
        _print_table(console, "Steps", STEP_COLUMNS, map(_step_row, summary.steps))
    if summary.final is not None:
        _print_table(console, "Vehicles", VEHICLE_COLUMNS, map(_vehicle_row, summary.final.vehicles))
    _print_table(console, "Frames", ("vehicle", "frames", "time ± s"), map(_frames_row, summary.frames))
    _print_table(console, "Settings of vehicles", SETTINGS_COLUMNS, map(_settings_row, summary.settings))
    actions = [
        (_utc(action.utc_s), action.action, _ids(action.vehicle_ids), _result(action)) for action in summary.actions
    ]
    _print_table(console, "Actions", ("utc", "action", "vehicles", "result"), actions)
    notices = [
        (
            f"{notice.elapsed_s:.0f}",
            notice.severity,
            "" if notice.vehicle_id is None else str(notice.vehicle_id),
            notice.text,
        )
        for notice in summary.notices
    ]
    _print_table(console, "Notices", ("at s", "severity", "vehicle", "text"), notices)
    files = [(file.path, str(file.files), _size(file.size_bytes)) for file in summary.files]
    _print_table(console, "Files", ("path", "files", "size"), files)


def _headline(summary: MissionSummary) -> str:
    if summary.outcome is None:
        return f"{summary.folder}: not closed (in flight, or interrupted)"
    words = {Outcome.FOUND: "possible person found", Outcome.NOT_FOUND: "nothing found"}
    return f"{summary.folder}: {words.get(summary.outcome.outcome, summary.outcome.outcome)}"


def _facts(summary: MissionSummary) -> Iterable[str]:
    final, manifest = summary.final, summary.manifest
    if "operation" in manifest:
        yield f"sortie {manifest['sortie']} of operation {manifest['operation']}"
    if final is not None:
        flown = f"{len(final.vehicles)} vehicles, {final.elapsed_s:.0f} s, {len(summary.steps)} steps"
        yield f"strategy {final.strategy}, {flown}"
        yield _target(final)
        if final.min_separation_m is not None:
            yield f"smallest separation {final.min_separation_m:.2f} m"
        if final.ground is not None:
            yield from figure_lines(final.ground)
        yield f"phase {final.phase}: {final.message}"
        yield from map(_finding, final.findings)
    if summary.steps:
        best = max(summary.steps, key=lambda step: step.visibility_m2)
        yield f"best visibility {best.visibility_m2:.2f} m² in step {best.step}"
    if summary.outcome is not None:
        for name, value in summary.outcome.summary.items():
            yield f"{name}: {value}"


def _target(final: MissionSnapshot) -> str:
    if final.target is None:
        return "no target estimate"
    sigma = "" if final.target.sigma_m is None else f" ± {final.target.sigma_m:.2f} m"
    return f"target at {_point(final.target.position_enu_m)} m ENU{sigma}, {final.target.sightings} sightings"


def _finding(finding: Finding) -> str:
    likely = "" if finding.person_confidence is None else f", {finding.person_confidence:.0%} a person"
    status = "" if finding.status is FindingStatus.NEW else f", {finding.status} by {finding.operator or 'an operator'}"
    reasons = f" ({'; '.join(finding.reasons)})" if finding.reasons else ""
    name = KIND_NAMES[finding.kind]
    status += f", found in {finding.found_in}" if finding.found_in else ""
    if finding.merged_into is not None:
        return f"finding {finding.finding_id}: the same as finding {finding.merged_into}"
    return f"finding {finding.finding_id}: {name} at {_point(finding.position_enu_m)} m ENU{likely}{status}{reasons}"


STEP_COLUMNS = ("step", "at s", "phase", "visibility m²", "branch", "e_f", "state", "leader", "missing")


def _step_row(step: StepRecord) -> Row:
    return (
        str(step.step),
        f"{step.elapsed_s:.0f}",
        step.phase,
        f"{step.visibility_m2:.3f}",
        step.branch,
        "" if step.evolutionary_factor is None else f"{step.evolutionary_factor:.3f}",
        step.evolutionary_state or "",
        "" if step.leader_id is None else str(step.leader_id),
        ", ".join(f"{vehicle_id} ({reason})" for vehicle_id, reason in step.missing.items()),
    )


VEHICLE_COLUMNS = ("vehicle", "task", "mode", "battery", "ENU m", "refusal")


def _vehicle_row(vehicle: VehicleSnapshot) -> Row:
    telemetry = vehicle.telemetry
    return (
        str(telemetry.vehicle_id),
        vehicle.task,
        telemetry.mode_name or telemetry.mode,
        "" if telemetry.battery_fraction is None else f"{telemetry.battery_fraction:.0%}",
        "" if vehicle.position_enu_m is None else _point(vehicle.position_enu_m),
        vehicle.refusal or "",
    )


def _frames_row(count: FrameCount) -> Row:
    if count.time_sigma_s is None:
        sigma = "unknown"
    else:
        sigma = " to ".join(dict.fromkeys(f"{sigma_s:.3g}" for sigma_s in count.time_sigma_s))
    return (str(count.vehicle_id), str(count.frames), sigma)


SETTINGS_COLUMNS = ("utc", "vehicle", "purpose", "before the mission", "what was done")


def _settings_row(record: SettingsRecord) -> Row:
    before = ", ".join(f"{name} = {value:g}" for name, value in record.former.items())
    done = "restored" if record.is_restored else "changed"
    return (_utc(record.utc_s), str(record.vehicle_id), record.purpose, before, done)


def _ids(vehicle_ids: tuple[int, ...] | None) -> str:
    return "all" if vehicle_ids is None else ", ".join(map(str, vehicle_ids))


def _result(action: ActionRecord) -> str:
    """Return what became of an action, by the vehicles that refused it too."""
    if action.refusal is not None:
        return f"refused: {action.refusal}"
    refused = [f"vehicle {one.vehicle_id}: {one.text}" for one in action.results if not one.accepted]
    if not refused:
        return "accepted"
    accepted = len(action.results) - len(refused)
    return f"accepted by {accepted}, refused by {len(refused)}: {'; '.join(refused)}"


def _utc(utc_s: float) -> str:
    return datetime.fromtimestamp(utc_s, UTC).strftime("%Y-%m-%d %H:%M:%S")


def _point(point_enu_m: EnuPoint) -> str:
    return "({:.1f}, {:.1f}, {:.1f})".format(*point_enu_m)


def _size(size_bytes: int) -> str:
    return f"{size_bytes / 1e6:.1f} MB" if size_bytes >= 1e5 else f"{size_bytes / 1e3:.1f} kB"


def _print_table(console: Console, title: str, columns: Row, rows: Iterable[Row]) -> None:
    rows = list(rows)
    if not rows:
        return
    table = Table(box=box.SIMPLE_HEAD if console.is_terminal else None, title=title, title_justify="left")
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console.print()
    console.print(table)
