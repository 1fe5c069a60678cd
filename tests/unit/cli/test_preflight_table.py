"""The matrix of preflight on the terminal."""

from __future__ import annotations

from dataclasses import replace

from aos_gcs.cli.display.live import Matrix
from aos_gcs.cli.display.preflight_table import preflight_table
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.checks import CheckOverride, PreflightCheck
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.preflight import checks
from tests.fakes.mission import ScriptedMission


def test_every_check_is_a_row_and_every_problem_a_note() -> None:
    fence = checks.failed(12, checks.GEOFENCE, "none", "upload it")
    found = [
        checks.warned(checks.MISSION, "aperture", "too narrow", "fly higher"),
        checks.passed(1, checks.LINK, "heard"),
        checks.warned(1, checks.CLOCK, "offset not known", "wait"),
        checks.passed(12, checks.LINK, "heard"),
        replace(fence, overridden=CheckOverride("indoors", "Ada", 0.0)),
        checks.failed(1, checks.BATTERY, "40 %", "change it"),
        checks.failed(12, checks.BATTERY, "40 %", "change it"),
    ]
    assert preflight_table(found).splitlines() == [
        "           1  12",
        "link       ✓   ✓",
        "clock      !   ·",
        "geofence   ·   o",
        "battery    ✗   ✗",
        "! aperture: too narrow; fly higher",
        "! vehicle 1, clock: offset not known; wait",
        "o vehicle 12, geofence: none; upload it (overridden by Ada: indoors)",
        "✗ vehicles 1, 12, battery: 40 %; change it",
    ]


def test_checks_of_the_mission_need_no_matrix() -> None:
    text = preflight_table([checks.failed(checks.MISSION, checks.VEHICLES, "0 of 3 are heard", "switch them on")])
    assert text == "✗ vehicles: 0 of 3 are heard; switch them on"


async def test_it_is_printed_when_news_are_worth_it() -> None:
    news = Matrix()
    mission = ScriptedMission(LoopClock())
    base = mission.snapshot()

    def is_news(phase: Phase, utc_s: float, *found: PreflightCheck) -> bool:
        return news.is_news(replace(base, phase=phase, preflight=found), utc_s)

    fence, link = checks.failed(1, checks.GEOFENCE, "none", "upload it"), checks.failed(1, checks.LINK, "old", "look")
    assert not is_news(Phase.CONNECT, 0.0)
    assert not is_news(Phase.PREFLIGHT, 5.0, fence, link), "vehicles that start up fail much"
    assert is_news(Phase.PREFLIGHT, 20.0, fence, link)
    assert not is_news(Phase.PREFLIGHT, 30.0, replace(fence, text="still none"), link)
    assert is_news(Phase.PREFLIGHT, 41.0, fence)
    assert not is_news(Phase.PREFLIGHT, 42.0, link)
    assert is_news(Phase.READY, 43.0, checks.passed(1, checks.LINK, "heard"))
    assert not is_news(Phase.ARM, 44.0, checks.passed(1, checks.LINK, "heard"))
