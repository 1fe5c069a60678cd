"""Task study: what an operator does on the page, and how long that takes, by pointer and by keyboard alone.

Four tasks by the operator's guide, in Chromium, with the real station and simulated vehicles as processes of their
own: from opening the page to the launch, from the alert to the confirmed finding, from *Done* to the next launch, and
from opening the page again, where the browser knows the operator's name, to the launch.
A mission file gives area and number of vehicles. Needs the built page and Chromium (AOS_GCS_CHROMIUM, or one on the
PATH).

An action is a click, a key, a field that is typed, or a held press; on the way to a button by keyboard, each press of
Tab is one. Before each action the script waits as long as the keystroke-level model says (Card, Moran and Newell,
doi:10.1145/358886.358895), so that figures repeat. What vehicles take, such as for preflight, is measured apart.

Usage: ``python tests/benchmarks/bench_tasks.py [pointer] [keyboard]``. ``AOS_GCS_CHECKOUT=DIR`` studies the page of
another checkout, with its own station and vehicles: ``git worktree add DIR b990b0a8`` has the first edition; build its
page by ``npm ci && npm run build`` in its ``web/``.
"""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from playwright.async_api import Browser, Locator, Page, async_playwright, expect

sys.path.insert(0, os.environ.get("AOS_GCS_CHECKOUT") or str(Path(__file__).resolve().parents[2]))

from tests.browser.station import FLIGHT_MS, START_TIMEOUT_S, Station
from tests.fakes.program import Program, running

CHECKOUT = Path(sys.path[0]).resolve()
IS_FIRST_EDITION = not (CHECKOUT / "web/src/views/prepare/choice.tsx").exists()
"""Whether the page lacks vehicles to confirm, a way from the alert to the finding, and another sortie in place."""
DEVICES = ("pointer", "keyboard")
ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"]
VIEW_KEYS = {"prepare": "r", "fly": "f", "decide": "d"}
VEHICLES = 3
WORLD = ("--seed", "7", "--trees-per-ha", "30", "--image-size", "128")
"""Few trees, so that the person is seen whatever way the swarm takes."""
NAME = "Ada"
THINK_S, POINT_S, CLICK_S, KEY_S = 1.35, 1.1, 0.2, 0.28
"""Times of the keystroke-level model: to decide on an action, to point, to click, to press a key (average typist)."""
HELD_MS = 1000
"""Longer than the page asks for before a dangerous command."""
MAX_TABS = 80
STARTED = re.compile("arm|tak|line|scan|converg|found", re.IGNORECASE)
OVER = re.compile("done|finished", re.IGNORECASE)
FOUND = re.compile("person|target found", re.IGNORECASE)
SHOW_FINDING_KEY = "n"


@dataclass
class Operator:
    """Somebody who acts on the page by one device at a fixed pace, and what that has cost in the present task."""

    page: Page
    device: str
    actions: Counter[str] = field(default_factory=Counter)
    acted_s: float = 0.0
    vehicles_s: float = 0.0
    has_signed_in: bool = False
    """Whether the browser knows the operator's name."""
    began_s: float = field(default_factory=time.monotonic)

    async def click(self, target: str) -> None:
        """Press the button or link of a test id, or of a selector."""
        await self._reach(target)
        if self.device == "pointer":
            await self._act("clicks", CLICK_S, self._at(target).click(timeout=FLIGHT_MS))
        else:
            await self._act("keys", KEY_S, self.page.keyboard.press("Enter"))

    async def hold(self, target: str) -> None:
        """Hold a button until it has worked."""
        await self._reach(target)
        if self.device == "pointer":
            await self._act("holds", 0.0, self._at(target).click(delay=HELD_MS))
        else:
            await self._act("holds", 0.0, self.page.keyboard.press("Enter", delay=HELD_MS))
        self.acted_s += HELD_MS / 1000

    async def hold_until(self, target: str, done: Awaitable[None]) -> None:
        """Hold a button until what it does is done; all of that is the operator's time."""
        await self._reach(target)
        await self._act("holds", 0.0)
        if self.device == "pointer":
            await self._at(target).hover()
        before_s = time.monotonic()
        await (self.page.mouse.down() if self.device == "pointer" else self.page.keyboard.down("Enter"))
        await done
        await (self.page.mouse.up() if self.device == "pointer" else self.page.keyboard.up("Enter"))
        self.acted_s += time.monotonic() - before_s

    async def submit(self, button: str) -> None:
        """Send a form with the button, or by Enter in its field."""
        if self.device == "pointer":
            await self.click(button)
        else:
            await self._act("keys", KEY_S, self.page.keyboard.press("Enter"))

    async def type(self, target: str, text: str) -> None:
        """Type into a field; one that has the focus already needs no click."""
        if not await self._has_focus(target):
            await (self.click(target) if self.device == "pointer" else self._reach(target))
        await self._act("fields", THINK_S + KEY_S * len(text), self._at(target).fill(text))

    async def show(self, view: str) -> None:
        """Go to a view by its tab, or by its key."""
        await (self.click(f"view-{view}") if self.device == "pointer" else self.press(VIEW_KEYS[view]))

    async def press(self, key: str) -> None:
        """Press a key of the page's own."""
        await self._act("keys", THINK_S + KEY_S, self.page.keyboard.press(key))

    async def press_elsewhere(self, times: int) -> None:
        """Press keys outside of the page, or click there."""
        for _ in range(times):
            await self._act("keys", THINK_S + KEY_S)

    async def open(self, address: str) -> None:
        """Open an address that a terminal shows, in a new tab: click it there, or type it."""
        if self.device == "pointer":
            await self._act("clicks", THINK_S + POINT_S + CLICK_S)
        else:
            await self.press_elsewhere(2)  # to the browser, and to its line of addresses
            await self._act("fields", KEY_S * len(address))
        self.page = await self.page.context.new_page()
        await self.page.goto(address)
        await expect(self.page.get_by_test_id("connection")).to_have_attribute("data-state", "open", timeout=FLIGHT_MS)

    async def vehicles(self, done: Awaitable[None]) -> None:
        """Wait for vehicles, which is not the operator's time."""
        before_s = time.monotonic()
        await done
        self.vehicles_s += time.monotonic() - before_s

    def begin(self) -> None:
        """Begin another task."""
        self.actions, self.acted_s, self.vehicles_s = Counter(), 0.0, 0.0
        self.began_s = time.monotonic()

    def report(self, task: str) -> None:
        """Print what the task has cost."""
        answered_s = time.monotonic() - self.began_s - self.acted_s - self.vehicles_s
        kinds = ", ".join(f"{number} {kind}" for kind, number in sorted(self.actions.items()))
        print(f"{self.device:8} {task:28} {self.actions.total():3} actions ({kinds})", end=", ")
        print(f"{self.acted_s:.1f} s, answers of the station {answered_s:.1f} s", end=", ")
        print(f"vehicles {self.vehicles_s:.1f} s", flush=True)

    async def _reach(self, target: str) -> None:
        """Point at a button, or go on with Tab until it has the focus; once it can be pressed."""
        await expect(self._at(target)).to_be_enabled(timeout=FLIGHT_MS)
        await self._pause(THINK_S)
        if self.device == "pointer":
            await self._pause(POINT_S)
            return
        for _ in range(MAX_TABS):
            if await self._has_focus(target):
                return
            await self._act("keys", KEY_S, self.page.keyboard.press("Tab"))
        raise LookupError(f"{target} is not reached by {MAX_TABS} times Tab.")

    async def _act(self, kind: str, seconds: float, action: Awaitable[object] | None = None) -> None:
        await self._pause(seconds)
        self.actions[kind] += 1
        if action is not None:
            await action

    async def _pause(self, seconds: float) -> None:
        self.acted_s += seconds
        await asyncio.sleep(seconds)

    def _at(self, target: str) -> Locator:
        return self.page.locator(target).first if target.startswith("[") else self.page.get_by_test_id(target)

    async def _has_focus(self, target: str) -> bool:
        return bool(await self._at(target).evaluate("element => element === document.activeElement"))


class StudiedStation(Station):
    """Makes its operators' code itself, and flies vehicles that operators confirm where the page has them do so."""

    def _write_mission(self) -> Path:
        file = super()._write_mission()
        lines = file.read_text(encoding="utf-8").splitlines()
        kept = [line for line in lines if not line.startswith(("any_vehicles", "operator_code_file"))]
        file.write_text("\n".join(kept), encoding="utf-8")
        return file

    @asynccontextmanager
    async def serve(self) -> AsyncIterator[Program]:
        """Run the service, with a new mission."""
        self._starts += 1
        async with running(self.folder / f"service-{self._starts}", "run", str(self._write_mission())) as program:
            await program.until_logged("Dashboard for operators", START_TIMEOUT_S)
            yield program

    async def serve_again(self, service: Program, programs: AsyncExitStack) -> Program:
        """End the service and start it anew."""
        service.stop(signal.SIGINT)
        await service.ended(START_TIMEOUT_S)
        return await programs.enter_async_context(self.serve())


async def sign_in(operator: Operator, service: Program) -> None:
    """Open the operators' address; whose name the browser knows need not type it, and now not even confirm it."""
    is_known = operator.has_signed_in
    await operator.open(service.operator_url)
    if is_known and not IS_FIRST_EDITION:
        await expect(operator.page.get_by_test_id("operator")).to_have_text(NAME, timeout=FLIGHT_MS)
        return
    operator.has_signed_in = True
    if await operator.page.get_by_test_id("sign-in-name").input_value() == "":
        await operator.type("sign-in-name", NAME)
    if IS_FIRST_EDITION or operator.device == "keyboard":
        await operator.submit("sign-in-ok")
    # By pointer the name leaves its field by the press that launches.


async def launch(operator: Operator) -> None:
    """Prepare and launch."""
    page = operator.page
    if IS_FIRST_EDITION and await page.get_by_test_id("view-prepare").get_attribute("aria-current") is None:
        await operator.show("prepare")
    await operator.vehicles(expect(page.get_by_test_id("launch")).to_be_enabled(timeout=FLIGHT_MS))
    has_started = expect(page.get_by_test_id("phase")).to_have_text(STARTED, timeout=FLIGHT_MS)
    if IS_FIRST_EDITION:
        await operator.click("launch")
        await operator.hold("confirm-ok")
        await has_started
    else:
        await operator.hold_until("launch", has_started)


async def confirm_finding(operator: Operator) -> None:
    """Look at what the alert tells of, and confirm it."""
    page = operator.page
    if IS_FIRST_EDITION:
        await operator.show("decide")
        await operator.click("finding-1")
    elif operator.device == "keyboard":
        await operator.press(SHOW_FINDING_KEY)
    is_on_map = operator.device == "pointer" and not IS_FIRST_EDITION
    card, status = ("alerted-finding", "alerted-status") if is_on_map else ("finding-detail", "finding-status")
    picture = page.get_by_test_id(card).locator("img").first
    await expect(picture).to_have_js_property("complete", value=True, timeout=FLIGHT_MS)
    box = await picture.bounding_box()
    await operator.click("judge-confirmed")
    await expect(page.get_by_test_id(status)).to_contain_text("confirmed", timeout=FLIGHT_MS)
    print(f"The picture of the finding is {0 if box is None else box['width']:.0f} pixels wide.")


async def come_home(operator: Operator) -> None:
    """End the sortie, in the view Fly; none of the tasks."""
    await operator.show("fly")
    await operator.click("action-return")
    await operator.hold("confirm-ok")
    await expect(operator.page.get_by_test_id("phase")).to_have_text(OVER, timeout=FLIGHT_MS)


async def study(browser: Browser, device: str, folder: Path) -> None:
    """Do the tasks with one device and print what they cost."""
    station = StudiedStation(folder, VEHICLES)
    context = await browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    async with AsyncExitStack() as programs:
        await programs.enter_async_context(station.fly(VEHICLES, *WORLD))
        service = await programs.enter_async_context(station.serve())
        operator = Operator(await context.new_page(), device)
        await sign_in(operator, service)
        await launch(operator)
        operator.report("page opened to launch")

        await operator.show("fly")
        alert = operator.page.get_by_test_id("alert-bar").filter(has_text=FOUND)
        shown = alert if IS_FIRST_EDITION else operator.page.get_by_test_id("alerted-finding")
        await expect(shown).to_be_visible(timeout=FLIGHT_MS)
        operator.begin()
        await confirm_finding(operator)
        operator.report("alert to confirmed finding")

        await come_home(operator)
        operator.begin()
        if IS_FIRST_EDITION:
            await operator.press_elsewhere(4)  # to the terminal, Ctrl-C, the last command again, Enter
            service = await station.serve_again(service, programs)
            await sign_in(operator, service)
        else:
            await operator.click("action-new_sortie")
            await expect(operator.page.get_by_test_id("phase")).not_to_have_text(OVER, timeout=FLIGHT_MS)
        await launch(operator)
        operator.report("Done to the next launch")

        await come_home(operator)
        service = await station.serve_again(service, programs)
        operator.begin()
        await sign_in(operator, service)
        await launch(operator)
        operator.report("page opened again to launch")
    await context.close()


async def run(devices: Sequence[str]) -> None:
    """Study the page with each device."""
    chromium = os.environ.get("AOS_GCS_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        for device in devices:
            with tempfile.TemporaryDirectory() as folder:
                await study(browser, device, Path(folder))
        await browser.close()


if __name__ == "__main__":
    # The station and the vehicles are those of the checkout, too.
    os.environ["PYTHONPATH"] = os.pathsep.join(str(CHECKOUT / folder) for folder in (".", "drivers", "sim"))
    os.chdir(CHECKOUT)
    asyncio.run(run(sys.argv[1:] or DEVICES))
