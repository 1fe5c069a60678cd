"""The mission folder of a search that was flown in memory."""

from __future__ import annotations

from pathlib import Path

from aos_gcs.store.database import MissionDatabase
from tests.fakes.mission_flight import MemoryRecorder
from tests.fakes.records import frame_row


def write_search(folder: Path, recorder: MemoryRecorder) -> Path:
    """Write what a search has recorded, as its own recorder does, and return the folder."""
    database = MissionDatabase(folder, {})
    writes = [lambda database, search=search: database.add_search(search) for search in recorder.searches]
    rows = [frame_row(folder, step, frame) for step, frame in recorder.frames]
    writes += [lambda database, row=row: database.add_frame(row) for row in rows]
    for number, step in recorder.steps.items():
        state = recorder.states[number]
        writes.append(lambda database, step=step, state=state: database.add_step(step, state))
        writes.append(lambda database, number=number: database.add_decision(recorder.decisions[number]))
        if number in recorder.conclusions:
            writes.append(lambda database, number=number: database.add_conclusion(recorder.conclusions[number]))
    database.write(writes)
    database.close()
    return folder
