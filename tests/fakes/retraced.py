"""Decisions of a flown mission, made again from what it has recorded."""

from __future__ import annotations

from aos_gcs.mission.search.decisions.retrace import Retrace
from tests.fakes.mission_flight import MemoryRecorder


def check_decisions_again(recorder: MemoryRecorder) -> None:
    """Decide every step of the first search on record again; waypoints and targets must be those of the flight."""
    retrace = Retrace(recorder.searches[0])
    assert recorder.decisions
    for step, decision in sorted(recorder.decisions.items()):
        captures = [frame for number, frame in recorder.frames if number == step]
        again, record = retrace.decide(decision, captures).record, recorder.steps[step]
        assert (again.waypoints, again.target_enu_m) == (record.waypoints, record.target_enu_m)
        if step in recorder.conclusions:
            assert retrace.conclude(recorder.conclusions[step]).targets == recorder.conclusions[step].targets
