"""The greeting of a client: all that it has to know before the first event."""

from __future__ import annotations

import asyncio

import pytest

from aos_gcs.api.app import create_app
from aos_gcs.api.events.hub import EventHub
from aos_gcs.clock import LoopClock
from aos_gcs.ports import Severity
from tests.fakes.mission import ScriptedMission


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


@pytest.mark.looptime
async def test_a_reloaded_page_shows_an_alert_that_250_texts_followed(mission: ScriptedMission) -> None:
    hub = EventHub(mission)
    running = asyncio.create_task(hub.run())
    await asyncio.sleep(0)
    for severity, text in ((Severity.CRITICAL, "motors stopped"), *((Severity.INFO, f"{n}") for n in range(250))):
        mission.notify(severity, text)
        await asyncio.sleep(0)
    await asyncio.sleep(0.01)
    assert hub.hello().notices[0].text == "motors stopped"
    running.cancel()


@pytest.mark.parametrize("has_all", [True, False])
async def test_the_greeting_names_what_the_service_offers(mission: ScriptedMission, has_all: bool) -> None:
    hub = create_app(mission, commands=mission if has_all else None).state.hub
    offered = {"planning": has_all, "findings": has_all}
    expected = offered | dict.fromkeys(("viewer", "operation", "survey", "handover", "wall", "video"), False)
    assert hub.hello().capabilities.model_dump() == expected


async def test_a_step_with_all_its_waypoints_is_greeted_with_once(mission: ScriptedMission) -> None:
    for _ in range(3):
        mission.make_step()
    hello = EventHub(mission).hello()
    assert [step.step for step in hello.steps] == [1, 2, 3]
    assert not {"fitness", "missing", "target", "waypoints"} & set(hello.model_dump()["steps"][-1])
    assert hello.latest_step is not None
    assert len(hello.latest_step.waypoints) == len(mission.snapshot().vehicles)
