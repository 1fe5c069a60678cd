"""Another language on the page: chosen on the screen, at once, for everything, and kept."""

from __future__ import annotations

import re

import pytest
from playwright.async_api import Page, expect

from aos_gcs.ports import Severity
from tests.browser.conftest import PageRecord, Service
from tests.browser.pages import open_page, wait_for

pytestmark = pytest.mark.asyncio(loop_scope="session")

LOST = "link lost for 12 s: its own failsafe flies it now. Check its link"
SPEECH = """window.spoken = [];
speechSynthesis.speak = ({ lang, text }) => window.spoken.push([lang, text]);
speechSynthesis.cancel = () => {};"""


async def test_german_is_chosen_heard_and_kept(service: Service, page: Page, page_record: PageRecord) -> None:
    await page.add_init_script(SPEECH)
    await open_page(page, service.url, "prepare")
    await page.get_by_test_id("settings-open").click()
    await page.get_by_test_id("voice-speech").click()
    await page.get_by_test_id("language-de").click()
    await expect(page.get_by_test_id("settings-open")).to_have_text("Optionen")
    await page.keyboard.press("Escape")
    await expect(page.locator("html")).to_have_attribute("lang", "de")
    await expect(page.get_by_test_id("hold-all")).to_contain_text("ALLE HALTEN")
    await expect(page.get_by_test_id("check-1-battery")).to_have_attribute("aria-label", "Akku, Drohne 1: bestanden")
    service.mission.notify(Severity.CRITICAL, LOST, 4)
    await expect(page.get_by_test_id("alert-bar")).to_contain_text("Drohne 4: Funk seit 12 s verloren")
    # It speaks after it has drawn, and also of a mission that seems silent where the page itself had to stand still.
    words = ["de", "Drohne 4: Funk seit 12 s verloren: Ihre Notfunktion fliegt sie. Funkverbindung prüfen"]
    await wait_for(page, "words => window.spoken.some(spoken => spoken.join() === words.join())", words)
    requested: list[str] = []
    page.on("request", lambda request: requested.append(request.url))
    await page.reload()
    await expect(page.get_by_test_id("connection")).to_have_text("Verbunden")
    languages = [url for url in requested if re.search(r"/assets/(english|german)-", url)]
    assert [re.sub(r".*/(\w+)-.*", r"\1", url) for url in languages] == ["german"]
    assert page_record.errors == []
