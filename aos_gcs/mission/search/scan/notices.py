"""Notices of the scan: ground without frames, stretches that are left out, and the end of all legs."""

from __future__ import annotations

from typing import Final

from aos_gcs.mission.journal import Announcer
from aos_gcs.mission.search.scan.progress import ScanProgress
from aos_gcs.ports import Severity

_MOST: Final = 0.5
"""Share of the area below which it was not scanned, whatever was flown."""


def tell_gap(journal: Announcer, progress: ScanProgress, along_m: float) -> None:
    """Tell that ground was flown over without frames, up to a place along the present leg."""
    text = f"No frames from {progress.along_m:.0f} to {along_m:.0f} m of leg {progress.leg + 1}: the line flies back"
    journal.notice(Severity.WARNING, text)


def tell_blocked(journal: Announcer, progress: ScanProgress, ahead_m: float | None, left_out_m: float) -> None:
    """Tell that the present leg is blocked, and what is left out.

    Args:
        journal: told it.
        progress: legs of the scan, with the waypoints that are barred.
        ahead_m: length that is left out; None: the rest of the leg.
        left_out_m: the same in metres.
    """
    barred = progress.barred[0]
    rest = "the rest of it" if ahead_m is None else f"{left_out_m:.0f} m and continues behind"
    journal.notice(
        Severity.WARNING,
        f"Leg {progress.leg + 1} is blocked after {progress.along_m:.0f} of {progress.present_leg.length_m:.0f} m "
        f"(vehicle {barred.vehicle_id}: {barred.reason}). The scan leaves out {rest}",
    )


def tell_end(journal: Announcer, persons: int, left_out_m: float, covered: float | None) -> None:
    """Tell that all legs have been flown.

    Args:
        journal: told it.
        persons: possible persons that were found.
        left_out_m: length of the legs that was left out.
        covered: share of the area that was in a usable frame; None where no frame was.
    """
    result = {0: "nothing was found", 1: "1 possible person was found"}.get(
        persons, f"{persons} possible persons were found"
    )
    if left_out_m == 0.0 and covered is not None and covered < _MOST:
        journal.notice(
            Severity.NEWS,
            f"Scan complete, {result}. Only {100 * covered:.0f} % of the area was in a usable frame: check the cameras "
            "and the height of the focal plane",
        )
    elif left_out_m == 0.0:
        journal.notice(Severity.NEWS, f"Scan complete: the whole area was scanned, {result}")
    else:
        journal.notice(
            Severity.NEWS,
            f"Scan complete, {result}. {left_out_m:.0f} m of its legs were left out; "
            f"{100 * (covered or 0.0):.0f} % of the area was in a frame",
        )
