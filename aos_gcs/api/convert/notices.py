"""Conversion of notices and their acknowledgements."""

from __future__ import annotations

from aos_gcs.api.models.notices import AcknowledgementModel, NoticeModel
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.snapshot import Acknowledgement


def notice(record: NoticeRecord) -> NoticeModel:
    """Convert a notice."""
    return NoticeModel(
        severity=record.severity,
        notice_id=record.notice_id,
        text=record.text,
        vehicle_id=record.vehicle_id,
        track_id=record.track_id,
        elapsed_s=record.elapsed_s,
        utc_s=record.utc_s,
    )


def acknowledgement(given: Acknowledgement) -> AcknowledgementModel:
    """Convert an acknowledgement."""
    return AcknowledgementModel(notice_id=given.notice_id, operator=given.operator, utc_s=given.utc_s)
