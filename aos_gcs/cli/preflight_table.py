"""The matrix of preflight as text: one row per check, one column per vehicle, and what is not as it should be."""

from __future__ import annotations

from collections.abc import Sequence

from aos_gcs.mission.checks import MISSION
from aos_gcs.mission.model import CheckStatus, PreflightCheck

_SIGNS = {CheckStatus.PASS: "✓", CheckStatus.WARN: "!", CheckStatus.FAIL: "✗"}
_OVERRIDDEN = "o"
_EMPTY = "·"


def preflight_table(found: Sequence[PreflightCheck]) -> str:
    """Return the matrix, and below it every check that does not simply pass, with its remedy or override."""
    cells = {(check.name, check.vehicle_id): check for check in found if check.vehicle_id != MISSION}
    names = dict.fromkeys(name for name, _ in cells)
    vehicle_ids = sorted({vehicle_id for _, vehicle_id in cells})
    width = max(map(len, names), default=0)
    rows = [" " * width + "".join(f"{vehicle_id:>4}" for vehicle_id in vehicle_ids)]
    for name in names:
        signs = [_sign(cells.get((name, vehicle_id))) for vehicle_id in vehicle_ids]
        rows.append(name.ljust(width) + "".join(f"{sign:>4}" for sign in signs))
    notes = [_note(check) for check in found if check.status is not CheckStatus.PASS]
    return "\n".join([*(rows if names else []), *notes])


def _sign(check: PreflightCheck | None) -> str:
    if check is None:
        return _EMPTY
    return _OVERRIDDEN if check.overridden else _SIGNS[check.status]


def _note(check: PreflightCheck) -> str:
    text = f"{_sign(check)} {check.describe()}"
    override = check.overridden
    return text if override is None else f"{text} (overridden by {override.by or 'the operator'}: {override.reason})"
