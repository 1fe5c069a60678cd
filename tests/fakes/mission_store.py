"""Recorders and readers of missions under one folder."""

from __future__ import annotations

from contextlib import AbstractAsyncContextManager
from pathlib import Path

from aos_gcs.ports import Notice
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder


class Store:
    """Opens recorders under one root and keeps their notices."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.notices: list[Notice] = []

    def record(self, mission_id: str = "m", **manifest: object) -> AbstractAsyncContextManager[MissionRecorder]:
        return MissionRecorder.create(self.root, mission_id, manifest, notify=self.notices.append)

    def read(self, mission_id: str = "m") -> MissionReader:
        return MissionReader(self.root / mission_id)
