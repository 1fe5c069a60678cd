"""The addresses that a station announces, and the one that it opens itself."""

from __future__ import annotations

import queue
from pathlib import Path

import pytest

from aos_gcs.api.listener import ServerAddress
from aos_gcs.config.model import ApiConfig
from aos_gcs.runtime.sign_in import announce
from tests.timing import scaled_s

ADDRESS = ServerAddress("127.0.0.1", 8080, is_encrypted=False)


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> queue.Queue[str]:
    """What was opened, on a machine with a screen and a browser."""
    addresses: queue.Queue[str] = queue.Queue()

    def open_it(url: str) -> bool:
        addresses.put(url)
        return True

    monkeypatch.setattr("webbrowser.open", open_it)
    monkeypatch.setenv("DISPLAY", ":0")
    return addresses


def test_the_page_is_opened_by_the_operators_address_where_that_has_the_code(opened: queue.Queue[str]) -> None:
    announce(ADDRESS, ApiConfig(open_browser=True), "the-code")
    assert opened.get(timeout=scaled_s(30.0)) == "http://127.0.0.1:8080/#code=the-code"


@pytest.mark.parametrize("given", [{"operator_code_file": Path("code")}, {"accounts": Path("accounts")}])
def test_a_code_of_a_file_and_accounts_are_in_no_address(opened: queue.Queue[str], given: dict[str, Path]) -> None:
    announce(ADDRESS, ApiConfig(open_browser=True, **given), "the-code")
    assert opened.get(timeout=scaled_s(30.0)) == "http://127.0.0.1:8080/"


def test_nothing_is_opened_unless_asked_for_or_without_a_screen(
    opened: queue.Queue[str], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    announce(ADDRESS, ApiConfig(), "the-code")
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    announce(ADDRESS, ApiConfig(open_browser=True), "the-code")
    assert "this terminal has no screen" in caplog.text
    assert opened.empty()


def test_a_machine_without_a_browser_is_told_of(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    class AtOnce:
        def __init__(self, target: object, **_: object) -> None:
            self.start = target

    monkeypatch.setattr("webbrowser.open", lambda _: False)
    monkeypatch.setattr("threading.Thread", AtOnce)
    monkeypatch.setenv("DISPLAY", ":0")
    announce(ADDRESS, ApiConfig(open_browser=True), "the-code")
    assert "none was found" in caplog.text
