"""The page at a command post: everybody signs in with an account, and sees what their role may do."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import argon2
import pytest
from playwright.async_api import Page, expect

from aos_gcs.api.access import passwords
from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.roles import Role
from tests.browser.conftest import PageRecord, serving
from tests.fakes.app import app_of

pytestmark = [pytest.mark.browser, pytest.mark.realtime, pytest.mark.asyncio(loop_scope="session")]

PASSWORD = "larch and spruce"  # noqa: S105 - of the tests


async def sign_in(page: Page, name: str) -> None:
    await page.get_by_test_id("sign-in-name").fill(name)
    await page.get_by_test_id("sign-in-password").fill(PASSWORD)
    await page.get_by_test_id("sign-in-ok").click()
    await expect(page.get_by_test_id("sign-in")).to_have_count(0)


async def test_roles_on_the_page(
    page: Page,
    *,
    page_record: PageRecord,
    other_page: Page,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    dashboard_build: None,  # noqa: ARG001 - asked for its check only
) -> None:
    hasher = argon2.PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
    monkeypatch.setattr(passwords, "_hasher", lambda: hasher)
    accounts = AccountFile(tmp_path / "accounts.json")
    accounts.add("Ada", Role.ADMINISTRATOR, PASSWORD, 0.0)
    async with serving(partial(app_of, accounts=accounts)) as service:
        await page.goto(service.url)
        # Who has not signed in is asked to, and sees nothing of the mission.
        await expect(page.get_by_test_id("sign-in")).to_be_visible()
        await expect(page.get_by_test_id("phase")).to_have_count(0)
        await sign_in(page, "Ada")
        await expect(page.get_by_test_id("phase")).to_be_visible()
        await expect(page.get_by_test_id("operator")).to_have_text("Ada")
        await expect(page.get_by_test_id("hold-all")).to_be_visible()
        # An administrator invites an analyst, who makes an account by the link.
        await page.get_by_test_id("settings-open").click()
        await expect(page.get_by_test_id("account-Ada")).to_be_visible()
        await page.get_by_label("Role of the new account").select_option("analyst")
        await page.get_by_test_id("invite").click()
        await expect(page.get_by_test_id("invite-only-here")).to_contain_text("works on this computer only")
        link = await page.get_by_test_id("invite-link").input_value()
        await other_page.goto(link)
        await sign_in(other_page, "Anders")
        assert "invite" not in other_page.url
        await expect(other_page.get_by_test_id("analyst")).to_have_text("Analyst")
        await expect(other_page.get_by_test_id("phase")).to_be_visible()
        await expect(other_page.get_by_test_id("hold-all")).to_have_count(0)
        # Promoted while signed in: the page knows when it asks again.
        await page.get_by_test_id("settings-close").click()
        await page.get_by_test_id("settings-open").click()
        await page.get_by_label("Role: Anders").select_option("operator")
        await expect(page.get_by_test_id("sign-ins")).to_contain_text(
            re.compile(r"Ada: role changed \(Anders: operator\)")
        )
        await other_page.reload()
        await expect(other_page.get_by_test_id("hold-all")).to_be_visible()
        # Of two operators one has control; the other asks for it, and gets it.
        await other_page.get_by_test_id("control").click()
        await other_page.get_by_test_id("control-take").click()
        await expect(other_page.get_by_test_id("control")).to_have_text("You have control")
        await page.get_by_test_id("settings-close").click()
        await page.get_by_test_id("control").click()
        await page.get_by_test_id("control-ask").click()
        await expect(other_page.get_by_test_id("control")).to_have_text("Ada asks for control")
        await other_page.get_by_test_id("control").click()
        await other_page.get_by_test_id("control-give").click()
        await expect(page.get_by_test_id("control")).to_have_text("You have control")
        await expect(other_page.get_by_test_id("control")).to_have_text("Ada has control")
        await page.keyboard.press("Escape")
        await page.get_by_test_id("settings-open").click()
        # An account that is removed sees nothing any more.
        await page.get_by_test_id("account-Anders").get_by_role("button").click()
        await page.get_by_test_id("account-Anders").get_by_role("button", name="Remove Anders now").click()
        await expect(page.get_by_test_id("account-Anders")).to_have_count(0)
        await expect(other_page.get_by_test_id("sign-in")).to_be_visible()
    refused = re.compile(r"WebSocket connection to .* failed|401 \(Unauthorized\)|ERR_CONNECTION_REFUSED")
    assert [error for error in page_record.errors if not refused.search(error)] == []
