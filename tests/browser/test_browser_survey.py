"""A survey in the browser: findings with pictures, other planes, decisions, the report; and no vehicles."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.async_api import Page, ViewportSize, expect

from aos_gcs.store.reader import MissionReader
from tests.browser.conftest import OPERATOR_CODE, PageRecord
from tests.browser.pages import TIMEOUT_MS, open_page, sign_in
from tests.fakes.program import running
from tests.fakes.survey_flight import Photographs
from tests.timing import scaled_s

pytestmark = pytest.mark.asyncio(loop_scope="session")

PHONE = ViewportSize(width=390, height=844)
# Coordinates have the whole width, and no picture lies over them.
REPORT_FITS = """() => {
    const [texts, picture] = [".report-finding dl", ".report-finding img"].map(
        (name) => document.querySelector(name).getBoundingClientRect());
    const root = document.documentElement;
    return root.scrollWidth <= root.clientWidth && texts.width > 250 && picture.top >= texts.bottom;
}"""


@pytest.mark.usefixtures("dashboard_build")
async def test_findings_of_a_folder_are_seen_and_judged(page: Page, page_record: PageRecord, tmp_path: Path) -> None:
    photographs, out, code = Photographs(tmp_path, hot=True), tmp_path / "results", tmp_path / "code.txt"
    code.write_text(OPERATOR_CODE, encoding="utf-8")
    options = ("--out", str(out), "--port", "0", "--operator-code-file", str(code))
    async with running(tmp_path / "run", "survey", str(photographs.images), *options) as program:
        await program.until_logged("Operators sign in there", scaled_s(60.0))
        found = re.search(r"Dashboard for observers: (\S+)", program.log)
        assert found is not None
        await page.goto(found[1])
        finding = page.get_by_test_id("finding-1")
        await expect(finding).to_be_visible(timeout=2 * TIMEOUT_MS)
        await expect(page.get_by_test_id("phase")).to_have_text("Examined")
        for view in ("plan", "prepare", "fly", "wall", "understand"):
            await expect(page.get_by_test_id(f"view-{view}")).to_have_count(0)

        await page.get_by_test_id("sign-in-open").click()
        await sign_in(page, "Ada", OPERATOR_CODE)
        await expect(finding).to_contain_text("Significance")
        await expect(finding).to_contain_text("frames")
        await finding.click()
        detail = page.get_by_test_id("finding-detail")
        await expect(detail).to_contain_text("seen in")
        await expect(detail).not_to_contain_text("vehicle")
        picture = page.get_by_test_id("finding-detail").locator("img").first
        await expect(picture).to_have_js_property("complete", value=True)
        await page.get_by_test_id("judge-confirmed").click()
        await expect(page.get_by_test_id("finding-status")).to_contain_text("confirmed · Ada")
        await expect(page.get_by_test_id("hold-all")).to_have_count(0)

        await page.get_by_test_id("settings-open").click()
        await expect(page.get_by_test_id("settings")).to_contain_text("See, Decide")
        await expect(page.get_by_test_id("settings")).not_to_contain_text("vehicle")
        await page.get_by_test_id("settings-close").click()

        await page.get_by_test_id("report-open").click()
        await expect(page.get_by_test_id("report-finding-1")).to_contain_text("Ada")
        await expect(page.get_by_test_id("report")).not_to_contain_text("Vehicles")
        await expect(page.get_by_test_id("report")).to_contain_text("6 of 6 pictures examined")
        await page.set_viewport_size(PHONE)
        assert await page.evaluate(REPORT_FITS)

        await open_page(page, found[1], "see")
        await expect(page.get_by_test_id("stage").locator("img").first).to_be_visible()
        await expect(page.get_by_test_id("mission-plane")).to_have_count(0)
        stage = await page.get_by_test_id("stage").bounding_box()
        assert stage is not None
        assert stage["height"] > 0.4 * PHONE["height"]
        assert page_record.errors == []
    with MissionReader(out) as reader:
        snapshot = reader.last_snapshot()
    assert snapshot is not None
    assert [(one.status, one.operator) for one in snapshot.findings] == [("confirmed", "Ada")]
