"""Launching in spite of a failed check."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import cast

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.overrides import BY_CONFIGURATION, Overrides
from aos_gcs.planning.settings import PreflightSettings
from tests.fakes.mission_flight import MemoryRecorder

pytestmark = pytest.mark.looptime

FENCE = checks.failed(3, checks.GEOFENCE, "none", "upload it")
LINK = checks.failed(3, checks.LINK, "heard 9.0 s ago", "check its radio")


@dataclass
class Bench:
    overrides: Overrides
    recorder: MemoryRecorder

    async def see(self, *found: PreflightCheck) -> tuple[PreflightCheck, ...]:
        return await self.overrides.review(found)


def bench(**standing: str) -> Bench:
    clock, recorder = LoopClock(), MemoryRecorder()
    settings = SimpleNamespace(preflight=PreflightSettings(overrides=standing))
    context = cast("FlightContext", SimpleNamespace(clock=clock, journal=Journal(clock), settings=settings))
    return Bench(Overrides(context, recorder), recorder)


async def test_an_override_is_shown_and_recorded_with_name_and_reason() -> None:
    b = bench()
    (check,) = await b.see(FENCE)
    assert check.blocks
    decided = await b.overrides.decide(3, checks.GEOFENCE, " indoor test ", "Ada")
    assert decided.overridden is not None
    assert (decided.overridden.reason, decided.overridden.by) == ("indoor test", "Ada")
    assert b.overrides.checks == (decided,)
    (check,) = await b.see(FENCE)
    assert check == decided
    assert not check.blocks
    (record,) = b.recorder.actions
    assert (record.action, record.vehicle_ids, record.check) == (Action.OVERRIDE, (3,), checks.GEOFENCE)
    assert (record.reason, record.operator, record.refusal) == ("indoor test", "Ada", None)


async def test_an_override_can_be_taken_back() -> None:
    b = bench()
    await b.see(FENCE)
    await b.overrides.decide(3, checks.GEOFENCE, "indoor test", "Ada")
    assert (await b.overrides.decide(3, checks.GEOFENCE, None, "Bob")).blocks
    assert (await b.see(FENCE))[0].blocks
    assert [(record.reason, record.operator) for record in b.recorder.actions] == [
        ("indoor test", "Ada"),
        (None, "Bob"),
    ]


@pytest.mark.parametrize(
    "changed",
    [checks.passed(3, checks.GEOFENCE, "as planned"), checks.failed(3, checks.GEOFENCE, "another", "remove it")],
)
async def test_an_override_ends_when_something_else_is_found(changed: PreflightCheck) -> None:
    b = bench()
    await b.see(FENCE)
    await b.overrides.decide(3, checks.GEOFENCE, "indoor test", "Ada")
    assert (await b.see(replace(FENCE, text="still none")))[0].overridden is not None
    assert (await b.see(changed))[0].overridden is None
    assert (await b.see(FENCE))[0].blocks, "an ended override must not come back"


async def test_a_gone_vehicle_leaves_others_alone() -> None:
    b = bench()
    other = replace(FENCE, vehicle_id=4)
    await b.see(FENCE, other)
    await b.overrides.decide(3, checks.GEOFENCE, "indoor test", "Ada")
    assert [check.blocks for check in await b.see(FENCE, other)] == [False, True]


@pytest.mark.parametrize(
    ("vehicle_id", "name", "reason", "text"),
    [
        (3, checks.LINK, "why not", "cannot be overridden: check its radio"),
        (3, checks.CAMERA, "why not", "No check 'camera' of vehicle 3; its checks are: geofence, link, battery"),
        (9, checks.LINK, "why not", "its checks are: none"),
        (3, checks.BATTERY, "why not", "has not failed"),
        (3, checks.GEOFENCE, "  ", "needs a reason"),
    ],
)
async def test_what_cannot_be_overridden_is_refused_on_record(
    vehicle_id: int, name: str, reason: str, text: str
) -> None:
    b = bench()
    await b.see(FENCE, LINK, checks.passed(3, checks.BATTERY, "90 %"))
    with pytest.raises(MissionError, match=text):
        await b.overrides.decide(vehicle_id, name, reason, "Ada")
    (record,) = b.recorder.actions
    assert record.refusal is not None
    assert all(check.overridden is None for check in b.overrides.checks)


async def test_the_configuration_overrides_failures_only_and_once_on_record() -> None:
    b = bench(**{checks.GEOFENCE: "netted hall", checks.LINK: "never"})
    for _ in range(2):
        found = await b.see(FENCE, LINK, checks.passed(4, checks.GEOFENCE, "as planned"))
        assert [check.blocks for check in found] == [False, True, False]
        assert found[0].overridden is not None
        assert found[0].overridden.by == BY_CONFIGURATION
        assert found[2].overridden is None
    (record,) = b.recorder.actions
    assert (record.vehicle_ids, record.operator, record.reason) == ((3,), BY_CONFIGURATION, "netted hall")
    assert found[0].status is CheckStatus.FAIL
