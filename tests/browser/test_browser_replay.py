"""A recorded mission in the browser: its time, its steps on other planes, and what is measured there."""

from __future__ import annotations

import hashlib
import re

import pytest
from playwright.async_api import Page, Route, expect

from tests.browser.conftest import PageRecord
from tests.browser.pages import open_page, place_m

pytestmark = pytest.mark.asyncio(loop_scope="session")

SCAN_S = 14.0
"""Recorded when the vehicles have left their launch points and the first steps are made."""


async def seek(page: Page, time_s: float) -> None:
    await page.get_by_test_id("replay-time").fill(str(time_s))


async def picture_hash(page: Page) -> str:
    """Return a fingerprint of the pixels that are shown."""
    return hashlib.sha256(await page.get_by_test_id("stage").screenshot()).hexdigest()


async def test_the_slider_moves_the_vehicles_and_nothing_can_be_commanded(
    page: Page, replayed: str, page_record: PageRecord
) -> None:
    await open_page(page, replayed)
    await expect(page.get_by_test_id("replay-bar")).to_contain_text("REPLAY")
    await expect(page.get_by_test_id("hold-all")).to_have_count(0)
    await expect(page.get_by_test_id("action-hold")).to_have_count(0)
    row = page.get_by_test_id("vehicle-1")
    await seek(page, 0.0)
    await expect(row).to_have_attribute("data-north", re.compile(r"^-38"))
    home = await place_m(page, 1)
    await seek(page, SCAN_S)
    await expect(page.get_by_test_id("phase")).to_have_text("Scanning")
    await expect(row).not_to_have_attribute("data-north", re.compile(r"^-38"))
    assert (await place_m(page, 1))[1] > home[1] + 10.0
    await page.keyboard.press("ArrowLeft")
    await page.get_by_test_id("replay-speed").select_option("16")
    await page.get_by_test_id("replay-play").click()
    await expect(page.get_by_test_id("phase")).to_have_text("Converging")
    await page.keyboard.press("u")
    await expect(page.get_by_test_id("plot-visibility")).to_have_attribute("aria-label", re.compile(r"visible \d"))
    await page.get_by_test_id("form-table").click()
    await expect(page.get_by_test_id("step-table")).to_contain_text("Exploitation")
    assert page_record.errors == []


async def test_notices_and_findings_are_marks_that_lead_there(
    page: Page, replayed: str, page_record: PageRecord
) -> None:
    await open_page(page, replayed, "understand")
    await expect(page).to_have_title(re.compile("^REPLAY "))
    marks, clock = page.get_by_test_id("replay-event"), page.get_by_test_id("replay-clock")
    finding = page.get_by_role("button", name=re.compile(r"Finding 1 \("))
    await expect(finding).to_have_count(1)
    await finding.hover()
    await expect(page.get_by_test_id("replay-tip")).to_contain_text("Finding 1")

    # By keyboard alone: from mark to mark, and to its time.
    await marks.first.focus()
    await page.keyboard.press("End")
    last = marks.nth(await marks.count() - 1)
    await expect(last).to_be_focused()
    await expect(page.get_by_test_id("replay-tip")).to_contain_text("second 30")
    await page.keyboard.press("Escape")
    await expect(page.get_by_test_id("replay-tip")).to_have_count(0)
    await page.keyboard.press("Enter")
    await expect(clock).to_contain_text("00:31 /")
    await page.get_by_test_id("replay-event-before").click()
    await expect(clock).not_to_contain_text("00:31 /")
    await page.locator("body").press("]")
    await expect(clock).to_contain_text("00:31 /")
    assert page_record.errors == []


async def test_a_legend_without_a_cursor_tells_the_latest_values(
    page: Page, replayed: str, page_record: PageRecord
) -> None:
    await open_page(page, replayed, "understand")
    values = page.get_by_test_id("plot-visibility").locator(".u-legend .u-value")
    areas = [re.compile(r"^\d\.\d\d\sm²$")] * 2
    for time_s, latest in ((30.0, "00:(2.|30)"), (SCAN_S, "00:1[0-4]")):
        await seek(page, time_s)
        await expect(values).to_have_text([re.compile(latest), *areas])
    assert page_record.errors == []


async def test_a_finger_draws_a_stretch_of_time_out_of_the_charts(
    page: Page, replayed: str, page_record: PageRecord
) -> None:
    await open_page(page, replayed, "understand")
    await seek(page, 30.0)
    over = page.get_by_test_id("plot-visibility").locator(".u-over")
    box = await over.bounding_box()
    assert box is not None
    session = await page.context.new_cdp_session(page)
    y = box["y"] + box["height"] / 2
    for kind, share in (("touchStart", 0.25), ("touchMove", 0.5), ("touchMove", 0.75), ("touchEnd", None)):
        points = [] if share is None else [{"x": box["x"] + share * box["width"], "y": y}]
        await session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    await expect(page.get_by_test_id("zoom-out")).to_be_visible()
    await page.get_by_test_id("zoom-out").click()
    await expect(page.get_by_test_id("zoom-out")).to_have_count(0)
    assert page_record.errors == []


async def test_a_late_autofocus_leaves_the_height_that_was_chosen_meanwhile(page: Page, replayed: str) -> None:
    await open_page(page, replayed, "see?step=1")
    await seek(page, SCAN_S)
    height, label = page.get_by_test_id("height"), page.get_by_test_id("picture-label")
    await expect(label).to_have_text(re.compile("Integral, step 1, plane at 0.0"))

    async def move_then_answer(route: Route) -> None:
        await height.fill("5")
        answer = {"found": True, "height_m": 1.5, "sigma_m": 0.2, "reason": ""}
        await route.fulfill(json=answer)

    await page.route("**/autofocus?*", move_then_answer)
    await page.get_by_test_id("autofocus").click()
    await expect(page.get_by_test_id("focus-result")).to_contain_text("1.50")
    await expect(height).to_have_value("5")


async def test_steps_are_focused_measured_and_compared(page: Page, replayed: str, page_record: PageRecord) -> None:
    await open_page(page, replayed, "see?step=1")
    await seek(page, SCAN_S)
    label = page.get_by_test_id("picture-label")
    await expect(label).to_have_text(re.compile("Integral, step 1, plane at 0.0"))
    ground = await picture_hash(page)
    await page.get_by_test_id("height").fill("5")
    await expect(label).to_have_text(re.compile("plane at 5.0"))
    assert await picture_hash(page) != ground
    await page.get_by_test_id("compare-toggle").click()
    await page.get_by_test_id("own-plane").click()
    await expect(label).to_have_text(re.compile("plane at 0.0"))
    await expect(page.get_by_test_id("picture-before")).to_have_attribute("alt", re.compile("plane at 5.0"))
    await page.get_by_test_id("compare-toggle").click()

    stage = page.get_by_test_id("stage")
    metres_per_px = float(await stage.get_attribute("data-metres-per-px") or "nan")
    await page.get_by_test_id("measure-toggle").click()
    await stage.click(position={"x": 200, "y": 150})
    await stage.click(position={"x": 320, "y": 310})
    measured = float(await page.get_by_test_id("measured").get_attribute("data-metres") or "nan")
    assert measured == pytest.approx(200.0 * metres_per_px, rel=0.02)
    scale = await page.get_by_test_id("stage-scale").bounding_box()
    words = await page.get_by_test_id("stage-scale").inner_text()
    assert scale is not None
    assert scale["width"] * metres_per_px == pytest.approx(float(words.split("\u202f")[0]), rel=0.02)

    await page.get_by_test_id("picture-frames").click()
    await page.get_by_test_id("frame-2").click()
    await expect(page.get_by_test_id("frame-large")).to_be_visible()
    assert page_record.errors == []


async def test_a_picture_is_moved_and_zoomed_by_keys_and_fingers(
    page: Page, replayed: str, page_record: PageRecord
) -> None:
    await open_page(page, replayed, "see?step=1")
    await seek(page, SCAN_S)
    stage, picture = page.get_by_test_id("stage"), page.get_by_test_id("picture")
    await expect(page.get_by_test_id("picture-label")).to_have_text(re.compile("Integral, step 1, plane at"))

    async def scale() -> float:
        return float(await stage.get_attribute("data-metres-per-px") or "nan")

    whole_m_per_px, at_first = await scale(), await picture.bounding_box()
    assert at_first is not None
    await stage.focus()
    await page.keyboard.press("+")
    assert await scale() == pytest.approx(whole_m_per_px / 1.4)
    await page.keyboard.press("Home")
    assert await scale() == pytest.approx(whole_m_per_px)
    await page.keyboard.press("ArrowRight")
    moved = await picture.bounding_box()
    assert moved is not None
    assert moved["x"] == pytest.approx(at_first["x"] - 60.0, abs=1.0)

    # Two fingers that move apart: twice as large, and what is between them stays there.
    box = await stage.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    session = await page.context.new_cdp_session(page)
    for kind, apart_px in (("touchStart", 50.0), ("touchMove", 75.0), ("touchMove", 100.0), ("touchEnd", None)):
        sides = () if apart_px is None else (-apart_px, apart_px)
        points = [{"x": x + side, "y": y, "id": index} for index, side in enumerate(sides)]
        await session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    assert await scale() == pytest.approx(whole_m_per_px / 2.0, rel=0.02)
    pinched = await picture.bounding_box()
    assert pinched is not None
    assert pinched["x"] - x == pytest.approx(2.0 * (moved["x"] - x), abs=3.0)
    assert page_record.errors == []


async def test_another_sortie_of_the_operation_can_be_replayed(
    page: Page, replayed: str, page_record: PageRecord
) -> None:
    await open_page(page, replayed, "understand")
    sorties = page.get_by_test_id("sorties")
    await expect(sorties.locator("tr[aria-current=true] th")).to_have_text("1")
    await sorties.get_by_test_id("show-sortie-2").click()
    await expect(sorties.locator("tr[aria-current=true] th")).to_have_text("2")
    await expect(page).to_have_title(re.compile("^REPLAY second"))
    await expect(page.get_by_test_id("another-mission")).to_have_count(0)
    await page.get_by_test_id("view-fly").click()
    await expect(page.get_by_test_id("vehicle-3")).to_be_visible()
    await expect(page.get_by_test_id("vehicle-4")).to_have_count(0)
    assert page_record.errors == []
