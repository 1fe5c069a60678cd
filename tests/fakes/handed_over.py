"""A recorded mission with flights, decided findings and a log, to hand over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.model.actions import Action, ActionRecord, ActionResult
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord
from aos_gcs.mission.model.findings import ErrorEllipse, Finding, FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import VehicleSnapshot
from aos_gcs.ports import LandedState, Severity
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes import records
from tests.fakes.scripted_ground import GROUND

START_UTC_S = 1_777_800_000.0
"""2026-05-03 09:20:00 UTC."""
FOUND = Finding(
    finding_id=1,
    status=FindingStatus.NEW,
    position_enu_m=(3.0, 4.0, 0.0),
    found_at_s=2.0,
    seen_at_s=3.0,
    step=0,
    track_id=1,
    ellipse=ErrorEllipse(0.6, 0.4, 1.0),
    sightings=5,
)


def state(at_s: float, *, up_m: float, battery: float | None = 0.9, findings: Sequence[Finding] = ()) -> Event:
    """Return the state of a mission of one vehicle, at a height and half a metre farther east every second."""
    snapshot = records.snapshot()
    vehicle = airborne(snapshot.vehicles[0], (0.5 * at_s, 0.0, up_m), battery)
    shown = replace(snapshot, elapsed_s=at_s, vehicles=(vehicle,), findings=tuple(findings), ground=GROUND)
    return Event(0, START_UTC_S + at_s, EventKind.SNAPSHOT, shown)


def airborne(vehicle: VehicleSnapshot, position_enu_m: EnuPoint, battery: float | None) -> VehicleSnapshot:
    landed = LandedState.IN_AIR if position_enu_m[2] > 0.0 else LandedState.ON_GROUND
    telemetry = replace(vehicle.telemetry, armed=True, landed=landed, battery_fraction=battery)
    return replace(vehicle, telemetry=telemetry, position_enu_m=position_enu_m, home_enu_m=(0.0, 0.0, 0.0))


def snapshot_of(event: Event) -> MissionSnapshot:
    assert isinstance(event.data, MissionSnapshot)
    return event.data


async def record_handed_over(
    root: Path, *, comment: str = "", operator: str = "Robin", status: FindingStatus = FindingStatus.CONFIRMED
) -> Path:
    """Record a flight of four seconds, a finding that an operator confirms, and an action that is refused."""
    decided = replace(FOUND, status=status, operator=operator, comment=comment, assignee="Team 2")
    states = [
        state(0.0, up_m=0.0),
        state(1.0, up_m=10.0, battery=0.9),
        state(3.0, up_m=10.0, battery=0.8, findings=[FOUND]),
        state(5.0, up_m=0.0, battery=0.7, findings=[decided]),
    ]
    notice = NoticeRecord(Severity.INFO, f"{operator}: finding 1 confirmed, comment: {comment}", None, 4.0, 1)
    manifest = {"aos_gcs": "0.1.0", "operation": "20260503-092000-ridge", "sortie": 2}
    async with MissionRecorder.create(root, "m", manifest, notify=lambda _: None) as recorder:
        for seq, event in enumerate(states, start=1):
            await recorder.record_event(replace(event, seq=seq))
        await recorder.record_event(Event(9, START_UTC_S + 4.0, EventKind.NOTICE, notice))
        refused = ActionRecord(START_UTC_S + 4.5, Action.START, None, (), refusal="it has begun", operator="Kim")
        await recorder.record_action(refused)
        lost = ActionResult(1, accepted=False, text="no link for 9 s")
        await recorder.record_action(ActionRecord(START_UTC_S + 4.6, Action.HOLD, None, (lost,), operator="Kim"))
    return root / "m"
