"""Notices that are kept for operators who look later."""

from __future__ import annotations

from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.notices import NOTICES_KEPT, notices_to_keep
from aos_gcs.ports import Severity


def notice(notice_id: int, severity: Severity, text: str = "") -> NoticeRecord:
    return NoticeRecord(severity, text or f"text {notice_id}", 1, 0.0, notice_id)


def ids(notices: list[NoticeRecord]) -> list[int]:
    return [each.notice_id for each in notices]


def test_no_flood_of_information_drops_an_open_alert() -> None:
    alerts = [notice(1, Severity.WARNING), notice(2, Severity.CRITICAL), notice(3, Severity.NEWS)]
    kept = notices_to_keep([*alerts, *(notice(10 + number, Severity.INFO) for number in range(250))], ())
    assert len(kept) == NOTICES_KEPT
    assert ids(kept)[:4] == [1, 2, 3, 63]


def test_what_is_acknowledged_or_said_again_goes_before_what_is_open() -> None:
    notices = [
        notice(1, Severity.CRITICAL, "link lost"),
        notice(2, Severity.CRITICAL, "motors stopped"),
        notice(3, Severity.WARNING),
        notice(4, Severity.CRITICAL, "link lost"),
        notice(5, Severity.CRITICAL, "geofence"),
    ]
    assert ids(notices_to_keep(notices, {5}, 4)) == [2, 3, 4, 5]
    assert ids(notices_to_keep(notices, {5}, 3)) == [2, 3, 4]
    assert ids(notices_to_keep(notices, {5}, 2)) == [2, 4]
    assert ids(notices_to_keep(notices, {4, 5}, 2)) == [2, 3]


def test_a_flood_of_open_alerts_is_bounded() -> None:
    assert ids(notices_to_keep([notice(number, Severity.CRITICAL) for number in range(300)], ()))[0] == 100
