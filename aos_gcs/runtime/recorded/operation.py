"""Sorties of an operation on the disk: their list, their frames, and which of them a replay shows."""

from __future__ import annotations

import asyncio
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from aos_gcs.mission.model.operation import SortieRecord
from aos_gcs.mission.viewing import ViewControl
from aos_gcs.ports import Clock, Worker
from aos_gcs.runtime.recorded.viewer import open_viewer, recorded_settings
from aos_gcs.store.operation import read_operation
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.replay import MissionReplay


class Operation:
    """Implementation of ``OperationView`` on the folder of one mission, in flight or ended.

    Args:
        folder: folder of the mission; those of the other sorties lie beside it.
        worker: computes the views; None: in threads of this process.
    """

    def __init__(self, folder: Path, worker: Worker | None = None) -> None:
        self._folder = folder
        self._worker = worker
        self._viewers: dict[str, ViewControl] = {}

    def keep(self, mission_id: str, viewer: ViewControl) -> None:
        """Use this viewer for a sortie."""
        self._viewers[mission_id] = viewer

    async def sorties(self) -> tuple[SortieRecord, ...]:
        """Return the sorties in the order of their numbers."""
        return await asyncio.to_thread(read_operation, self._folder)

    async def viewer(self, mission_id: str) -> ViewControl | None:
        """Return the views of a sortie's frames; None if the operation has no such sortie."""
        if mission_id not in self._viewers:
            folder = await self.folder_of(mission_id)
            if folder is None:
                return None
            self._viewers[mission_id] = await asyncio.to_thread(self._open_viewer, folder)
        return self._viewers[mission_id]

    async def folder_of(self, mission_id: str) -> Path | None:
        """Return the folder of a sortie; None if the operation has no such sortie."""
        for sortie in await self.sorties():
            if sortie.mission_id == mission_id:
                return self._folder.resolve().parent / sortie.folder
        return None

    def _open_viewer(self, folder: Path) -> ViewControl:
        with MissionReader(folder) as reader:
            return open_viewer(reader, self._worker)


class ReplayedOperation(Operation):
    """An operation of which one sortie is replayed; a context manager, which closes the records.

    Args:
        folder: folder of the sortie that is shown first.
        clock: clock of the replay.

    Raises:
        InputDataError: the folder holds no mission that can be shown.
    """

    def __init__(self, folder: Path, clock: Clock) -> None:
        super().__init__(folder)
        self.shown_folder = folder
        self._records = ExitStack()
        reader = self._records.enter_context(MissionReader(folder))
        self.replay = MissionReplay(reader, clock)
        settings = recorded_settings(reader)
        self.terrain = None if settings is None else settings.terrain
        """Elevation model of the operation; None if it has none, or a record of another version does not tell."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._records.close()

    async def show(self, mission_id: str) -> bool:
        """Show another sortie to all clients, and return whether there is one of that name; see ``SortieChoice``."""
        folder = await self.folder_of(mission_id)
        if folder is None:
            return False
        with ExitStack() as opened:
            # Nothing is awaited from here on: of two operators who choose at once, the later one has the last word.
            self.replay.show(opened.enter_context(MissionReader(folder)))
            former, self._records = self._records, opened.pop_all()
            former.close()
        self.shown_folder = folder
        return True
