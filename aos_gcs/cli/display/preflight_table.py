"""The preflight matrix as text: one row per check, one column per vehicle, and a note for each check not passed."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.preflight.checks import MISSION

_SIGNS = {CheckStatus.PASS: "✓", CheckStatus.WARN: "!", CheckStatus.FAIL: "✗"}
_OVERRIDDEN = "o"
_EMPTY = "·"


def preflight_table(found: Sequence[PreflightCheck]) -> str:
    """Return the matrix, and below it every check that has not passed, with its remedy or override."""
    cells = {(check.name, check.vehicle_id): check for check in found if check.vehicle_id != MISSION}
    names = dict.fromkeys(name for name, _ in cells)
    vehicle_ids = sorted({vehicle_id for _, vehicle_id in cells})
    width = max(map(len, names), default=0)
    rows = [" " * width + "".join(f"{vehicle_id:>4}" for vehicle_id in vehicle_ids)]
    for name in names:
        signs = [_sign(cells.get((name, vehicle_id))) for vehicle_id in vehicle_ids]
        rows.append(name.ljust(width) + "".join(f"{sign:>4}" for sign in signs))
    return "\n".join([*(rows if names else []), *_notes(found)])


def _notes(found: Sequence[PreflightCheck]) -> list[str]:
    """Return a line for each check that has not passed; vehicles with the same problem share one."""
    vehicles: dict[str, list[PreflightCheck]] = {}
    for check in found:
        if check.status is not CheckStatus.PASS:
            vehicles.setdefault(_problem(check), []).append(check)
    return [f"{_sign(checks[0])} {_subject(checks)}{problem}" for problem, checks in vehicles.items()]


def _problem(check: PreflightCheck) -> str:
    text = f"{check.name}: {check.text}; {check.remedy}" if check.remedy else f"{check.name}: {check.text}"
    override = check.overridden
    return text if override is None else f"{text} (overridden by {override.by or 'the operator'}: {override.reason})"


def _subject(checks: Sequence[PreflightCheck]) -> str:
    vehicle_ids = [check.vehicle_id for check in checks if check.vehicle_id != MISSION]
    if not vehicle_ids:
        return ""
    return f"vehicle{'s' if len(vehicle_ids) > 1 else ''} {', '.join(map(str, vehicle_ids))}, "


def _sign(check: PreflightCheck | None) -> str:
    if check is None:
        return _EMPTY
    return _OVERRIDDEN if check.overridden else _SIGNS[check.status]
