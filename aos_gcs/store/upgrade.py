"""Conversion of recordings of older versions."""

from __future__ import annotations

from typing import Any, Final

from aos_gcs.mission.model.checks import CheckStatus
from aos_gcs.mission.model.events import EventKind

OLDEST_VERSION: Final = 1
FIRST_WITH_SETTINGS: Final = 3
"""The version from which changed settings of vehicles are recorded, and the uncertainty of frames' times."""
FIRST_WITH_DECISIONS: Final = 4
"""The version from which a record holds what each decision depended on, and digests of the frames."""


def upgraded(version: int, kind: EventKind, data: Any) -> Any:
    """Return the content of an event as the present version would have recorded it.

    Args:
        version: version of the database.
        kind: kind of the event.
        data: as recorded.
    """
    if version == 1 and kind is EventKind.SNAPSHOT:
        return data | {"preflight": [_check_with_status(check) for check in data["preflight"]]}
    return data


def _check_with_status(check: dict[str, Any]) -> dict[str, Any]:
    """Convert a check of version 1, which only had passed or failed."""
    if "passed" not in check:
        return check
    rest = {name: value for name, value in check.items() if name != "passed"}
    return rest | {"status": (CheckStatus.PASS if check["passed"] else CheckStatus.FAIL).value}
