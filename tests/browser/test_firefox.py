"""The page in Firefox, where it is installed: what another browser may do otherwise, from the sign-in to the finding.

Firefox draws no map here: without a window it offers no WebGL. The map is tested in Chromium.
"""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from fastapi import FastAPI

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.findings import FindingStatus
from aos_gcs.planning.plan import plan_of
from tests.browser.conftest import OPERATOR_CODE, Service, serving, unavailable
from tests.browser.firefox import Firefox, firefox_path, running_firefox
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission

pytestmark = pytest.mark.asyncio(loop_scope="session")

STEPS_UNTIL_FOUND = 20


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def window(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Firefox]:
    path = firefox_path()
    if path is None:
        unavailable("no Firefox found: install it (Debian: firefox-esr), or name it in AOS_GCS_FIREFOX")
    async with running_firefox(path, tmp_path_factory.mktemp("firefox") / "profile") as window:
        yield window


@pytest_asyncio.fixture(loop_scope="session")
async def firefox(window: Firefox) -> AsyncIterator[Firefox]:
    """The window, which leaves the page behind each test: it would complain in the next that its service is gone."""
    yield window
    await window.open("about:blank")
    window.errors.clear()


async def test_an_operator_signs_in_holds_all_and_confirms_a_finding(
    firefox: Firefox,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
) -> None:
    def make_app(mission: ScriptedMission) -> FastAPI:
        return app_of(mission, operator_code=OPERATOR_CODE)

    async with serving(make_app) as service:
        await service.mission.act(Action.START, None)
        for _ in range(STEPS_UNTIL_FOUND):
            service.mission.make_step()
        await firefox.open(f"{service.url}#/decide")
        await firefox.until_text("connection", "Connected")
        await firefox.until_text("observer", "Observer")
        await firefox.press("sign-in-open")
        await firefox.fill("sign-in-name", "Ada")
        await firefox.fill("sign-in-code", OPERATOR_CODE)
        await firefox.press("sign-in-ok")
        await firefox.until_text("operator", "Ada")

        await firefox.press("finding-1")
        await firefox.press("judge-confirmed")
        await firefox.until_text("finding-status", "confirmed · Ada")
        assert [finding.status for finding in service.mission.findings.all()] == [FindingStatus.CONFIRMED]

        await firefox.press("view-fly")
        await firefox.until_text("task-1", "In swarm")
        await firefox.press("hold-all")
        await firefox.until_text("suspension", "Holding")
        assert firefox.errors == []


async def test_a_plan_is_changed_by_numbers_and_flown_in_german(firefox: Firefox, service: Service) -> None:
    await firefox.open(f"{service.url}#/plan")
    await firefox.until_text("shape-area", "4 corners")
    await firefox.until("document.querySelector('main').textContent.includes('The map needs WebGL')")
    await firefox.press("vertex-remove-3")
    await firefox.until_text("shape-area", "3 corners")
    await firefox.press("plan-apply")
    await firefox.until_text("plan-answer", "Plan applied")
    assert len(plan_of(service.mission.settings).area_enu_m) == 3

    await firefox.press("settings-open")
    await firefox.press("language-de")
    await firefox.press("settings-close")
    await firefox.until_text("hold-all", "ALLE HALTEN")
    await firefox.press("view-fly")
    await firefox.press("action-start")
    await firefox.press("confirm-ok", hold="document.querySelector('[data-testid=\"confirm\"]') === null")
    await firefox.until("/Aufstellung|Suche/.test(document.querySelector('[data-testid=\"phase\"]')?.textContent)")
    assert firefox.errors == []
