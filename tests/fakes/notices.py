"""A journal that keeps what it is told."""

from __future__ import annotations

from aos_gcs.ports import Severity


class Notices:
    """Journal that keeps severities, texts and tracks."""

    def __init__(self) -> None:
        self.severities: list[Severity] = []
        self.texts: list[str] = []
        self.track_ids: list[int | None] = []

    def elapsed_s(self) -> float:
        return 0.0

    def notice(self, severity: Severity, text: str, *_: object, track_id: int | None = None) -> None:
        self.severities.append(severity)
        self.texts.append(text)
        self.track_ids.append(track_id)
