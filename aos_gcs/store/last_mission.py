"""The mission recorded last, and whether it ended."""

from __future__ import annotations

from pathlib import Path

from aos_gcs.errors import InputDataError
from aos_gcs.mission.former_flight import FormerFlight
from aos_gcs.mission.model.events import EventKind, PlanRecord
from aos_gcs.mission.model.proposals import ProposalRecord
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.phases import ON_GROUND
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.schema import DATABASE_NAME

_LONGEST_GAP_S = 1800.0
"""Time after which no battery keeps a vehicle of a former flight in the air."""


def former_flight(missions: Path, now_utc_s: float) -> FormerFlight | None:
    """Return the flight that the station before has left, by its record; None if it has left none in the air.

    Args:
        missions: folder of all missions.
        now_utc_s: the present time; a flight of long ago is not taken up.
    """
    name = unfinished_mission(missions)
    if name is None:
        return None
    try:
        with MissionReader(missions / name) as reader:
            last, plans = reader.last_snapshot_event(), list(reader.events(EventKind.PLAN))
    except InputDataError:
        return None
    if last is None or not isinstance(last.data, MissionSnapshot):
        return None
    if last.data.phase in ON_GROUND or now_utc_s - last.utc_s > _LONGEST_GAP_S:
        return None
    plan = plans[-1].data if plans else None
    return FormerFlight(last.data, plan.plan if isinstance(plan, PlanRecord) else None, last.utc_s)


def last_proposals(missions: Path) -> tuple[ProposalRecord, ...]:
    """Return the proposals of others that the mission recorded last had, with the decisions; none if it cannot be read.

    Args:
        missions: folder of all missions, which need not exist.
    """
    folder = _last_folder(missions)
    if folder is None:
        return ()
    try:
        with MissionReader(folder) as reader:
            last = reader.last_snapshot()
    except InputDataError:
        return ()
    return () if last is None else last.proposals


def unfinished_mission(missions: Path) -> str | None:
    """Return the name of the mission recorded last if it has no outcome: its program was killed, or still runs.

    A record that cannot be read counts as unfinished.

    Args:
        missions: folder of all missions, which need not exist.
    """
    folder = _last_folder(missions)
    if folder is None:
        return None
    try:
        with MissionReader(folder) as reader:
            has_ended = reader.outcome() is not None
    except InputDataError:
        has_ended = False
    return None if has_ended else folder.name


def _last_folder(missions: Path) -> Path | None:
    return max((file.parent for file in missions.glob(f"*/{DATABASE_NAME}")), default=None)
