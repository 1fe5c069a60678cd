"""Proposals of others in a real browser: taken over and dismissed by operators, and by nobody else."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace
from functools import partial

import pytest
import pytest_asyncio
from playwright.async_api import Page, Route, expect

from aos_gcs.mission.model.proposals import Proposal, ProposalShape, ProposalUse
from tests.browser.conftest import OPERATOR_CODE, PageRecord, Service, serving
from tests.browser.pages import open_page, sign_in
from tests.fakes.app import app_of
from tests.fakes.mission import ORIGIN
from tests.unit.sharing.test_proposals import proposal

pytestmark = pytest.mark.asyncio(loop_scope="session")

MARKUP = "<img src=x onerror=alert(1)>"


def near(east: float, north: float) -> tuple[float, float]:
    """Return a place about so many metres from the origin."""
    return ORIGIN.latitude_deg + north / 111_200.0, ORIGIN.longitude_deg + east / 74_000.0


def drawn() -> list[Proposal]:
    """Return a closed shape, a point, and five marks of somebody who sends many."""
    ring = (near(-30.0, 0.0), near(30.0, 0.0), near(30.0, 60.0), near(-30.0, 60.0))
    area = replace(proposal("area", points_deg=ring), shape=ProposalShape.AREA, name="Sector 4", altitude_amsl_m=None)
    point = replace(proposal("point", points_deg=(near(0.0, 5.0),)), name=MARKUP, sender="EAGLE 1")
    marks = [
        replace(proposal(f"mark{number}", points_deg=(near(number, number),)), sender="LOUD", name=f"Mark {number}")
        for number in range(5)
    ]
    return [area, point, *marks]


@pytest_asyncio.fixture(loop_scope="session")
async def guarded(dashboard_build: None) -> AsyncIterator[Service]:  # noqa: ARG001 - its check
    async with serving(partial(app_of, operator_code=OPERATOR_CODE)) as service:
        service.mission.proposals.take(drawn())
        yield service


async def test_proposals_are_taken_over_and_dismissed_by_operators_only(
    page: Page, guarded: Service, page_record: PageRecord
) -> None:
    await open_page(page, guarded.url, "plan")
    panel = page.get_by_test_id("plan-proposals")
    await expect(panel.get_by_role("listitem")).to_have_count(7)
    await expect(page.get_by_test_id("proposal-2")).to_contain_text(MARKUP)
    await expect(panel.get_by_role("button")).to_have_count(0)

    await page.get_by_test_id("sign-in-open").click()
    await sign_in(page, "Ada", OPERATOR_CODE)
    await expect(page.get_by_test_id("shape-no_go[0]")).to_have_count(0)
    await page.get_by_test_id("proposal-1-no_go").click()
    await expect(page.get_by_test_id("shape-no_go[0]")).to_contain_text("4 corners")
    await expect(page.get_by_test_id("proposal-1")).to_have_count(0)
    await expect(page.get_by_test_id("plan-apply")).to_be_enabled()

    await page.get_by_test_id("proposal-2-dismissed").click()
    await expect(page.get_by_test_id("proposal-2")).to_have_count(0)

    dismiss = page.get_by_test_id("proposals-dismiss")
    await expect(dismiss).to_have_text("Dismiss all 5 from LOUD")
    await dismiss.click()
    await expect(panel).to_have_count(0)
    made = [(record.use, record.operator) for record in guarded.mission.proposals.all()]
    assert made == [(ProposalUse.NO_GO, "Ada"), *[(ProposalUse.DISMISSED, "Ada")] * 6]
    assert page_record.errors == []


async def test_what_is_taken_over_while_the_plan_is_read_again_stays(page: Page, guarded: Service) -> None:
    """Signing in connects anew, and so reads the plan again: on a slow link its answer comes after the first press."""
    await open_page(page, guarded.url, "plan")
    await expect(page.get_by_test_id("shape-area")).to_contain_text("4 corners")
    is_read, is_taken = asyncio.Event(), asyncio.Event()

    async def answer_late(route: Route) -> None:
        response = await route.fetch()
        is_read.set()
        await is_taken.wait()
        await route.fulfill(response=response)

    await page.route("**/api/plan", answer_late)
    await page.get_by_test_id("sign-in-open").click()
    await sign_in(page, "Ada", OPERATOR_CODE)
    await is_read.wait()
    await page.get_by_test_id("proposal-1-no_go").click()
    shape, overtaken = page.get_by_test_id("shape-no_go[0]"), page.get_by_test_id("plan-overtaken")
    await expect(shape).to_contain_text("4 corners")
    await expect(overtaken).to_be_visible()
    is_taken.set()
    await expect(overtaken).to_have_count(0)
    await expect(shape).to_contain_text("4 corners")
    await expect(page.get_by_test_id("plan-undo")).to_be_enabled()


async def test_what_is_taken_over_is_in_the_plan_although_another_view_is_open_by_then(
    page: Page, planned: Service
) -> None:
    await open_page(page, planned.url, "plan")
    is_left = asyncio.Event()

    async def answer_late(route: Route) -> None:
        response = await route.fetch()
        await is_left.wait()
        await route.fulfill(response=response)

    await page.route("**/api/proposals/1", answer_late)
    await page.get_by_test_id("proposal-1-no_go").click()
    await page.get_by_test_id("view-fly").click()
    await expect(page.get_by_test_id("plan-estimate")).to_have_count(0)
    async with page.expect_response("**/api/proposals/1"):
        is_left.set()
    await page.get_by_test_id("view-plan").click()
    await expect(page.get_by_test_id("shape-no_go[0]")).to_contain_text("4 corners")


async def test_a_proposal_that_somebody_else_has_decided_meanwhile_is_refused_in_words(
    page: Page, planned: Service
) -> None:
    await open_page(page, planned.url, "plan")

    async def arrive_after_bob(route: Route) -> None:
        planned.mission.proposals.decide(1, ProposalUse.DISMISSED, "Bob", 0.0)
        await route.continue_()

    await page.route("**/api/proposals/1", arrive_after_bob)
    await page.get_by_test_id("proposal-1-area").click()
    await expect(page.get_by_test_id("plan-proposals")).to_contain_text("Bob has decided about this proposal already")
    await expect(page.get_by_test_id("shape-area")).to_contain_text("4 corners")


@pytest_asyncio.fixture(loop_scope="session")
async def planned(dashboard_build: None) -> AsyncIterator[Service]:  # noqa: ARG001 - its check
    async with serving() as service:
        service.mission.proposals.take(drawn()[:1])
        yield service
