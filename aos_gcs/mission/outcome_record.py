"""Record of a mission's end: how it ended, and the figures of the whole."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aos_gcs.mission.context import MissionContext
from aos_gcs.mission.model.findings import Finding
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.search.decisions.decider import Decider


def outcome_record(
    context: MissionContext,
    outcome: Outcome,
    decider: Decider,
    persons: Sequence[Finding],
    *,
    min_separation_m: float | None,
) -> OutcomeRecord:
    """Return the record of a mission that ends now.

    Args:
        context: context of the mission.
        outcome: how it ended.
        decider: knows the target, and when the first person was announced.
        persons: findings of it that count as persons.
        min_separation_m: smallest distance measured between two vehicles in the air; None where there was none.
    """
    roster, journal, monitor = context.roster, context.journal, context.loop_monitor
    target, steps = decider.tracker.estimate(), journal.steps
    summary: dict[str, object] = {
        "message": journal.message,
        "duration_s": journal.elapsed_s(),
        "steps": len(steps),
        "time_to_detection_s": decider.found_at_s,
        "target_enu_m": None if target is None else target.position_enu_m,
        "target_sigma_m": None if target is None else target.sigma_m,
        "persons": [finding.finding_id for finding in persons],
        "vehicles": sum(member.takes_part for member in roster.members()),
        "landed": len(roster.members(Task.LANDED)),
        "min_separation_m": min_separation_m,
        "work_ms_median": float(np.median([step.work_ms for step in steps])) if steps else None,
        "loop_lag_p99_ms": monitor.lag_p99_ms(),
        "longest_stall_s": monitor.longest_stall_s,
    }
    return OutcomeRecord(context.clock.utc_s(), outcome, summary)
