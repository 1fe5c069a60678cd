"""A journal that keeps what it is told."""

from __future__ import annotations

from aos_gcs.ports import Severity


class Notices:
    """Journal that keeps the texts."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.track_ids: list[int | None] = []

    def elapsed_s(self) -> float:
        return 0.0

    def notice(
        self,
        severity: Severity,  # noqa: ARG002
        text: str,
        vehicle_id: int | None = None,  # noqa: ARG002
        *,
        track_id: int | None = None,
    ) -> None:
        self.texts.append(text)
        self.track_ids.append(track_id)
