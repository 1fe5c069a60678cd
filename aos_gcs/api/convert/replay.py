"""Conversion of replays."""

from __future__ import annotations

from aos_gcs.api.models.replay import (
    ReplayFindingModel,
    ReplayModel,
    ReplayNoticeModel,
    ReplayPhaseModel,
    ReplayStepModel,
    TimelineModel,
)
from aos_gcs.mission.control import ReplayState, Timeline


def replay_state(state: ReplayState) -> ReplayModel:
    """Convert the state of a replay."""
    return ReplayModel(
        time_s=round(state.time_s, 1),
        duration_s=round(state.duration_s, 1),
        speed=state.speed,
        playing=state.playing,
    )


def timeline(state: ReplayState, line: Timeline) -> TimelineModel:
    """Convert a replay and its timeline."""
    return TimelineModel(
        replay=replay_state(state),
        start_utc_s=line.start_utc_s,
        phases=[ReplayPhaseModel(time_s=round(time_s, 1), phase=phase) for time_s, phase in line.phases],
        steps=[ReplayStepModel(time_s=round(time_s, 1), step=step) for time_s, step in line.steps],
        notices=[
            ReplayNoticeModel(
                time_s=round(time_s, 1), severity=record.severity, text=record.text, vehicle_id=record.vehicle_id
            )
            for time_s, record in line.notices
        ],
        findings=[
            ReplayFindingModel(time_s=round(time_s, 1), finding_id=found.finding_id, status=found.status)
            for time_s, found in line.findings
        ],
    )
