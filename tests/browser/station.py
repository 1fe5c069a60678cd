"""A ground station with simulated vehicles, each a process of its own, for an operator who has nothing but the page."""

from __future__ import annotations

import re
import socket
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from playwright.async_api import Page, expect

from tests.browser.conftest import OPERATOR_CODE
from tests.browser.pages import confirm, hold, sign_in
from tests.fakes.program import Program, running, unused_port
from tests.timing import scaled_s

SPEED = 5.0
"""Simulated seconds per second: slow enough for the operator to act in flight on a machine that is busy."""
START_TIMEOUT_S = scaled_s(60.0)
FLIGHT_MS = 1000 * scaled_s(90.0)
"""Limit for flights, on a machine that is busy with other things."""
_PATIENT = ("--param", "FS_GCS_TIMEOUT=60", "--param", "DISARM_DELAY=120")
"""The autopilots' own clocks run as fast as the mission's, our heartbeats do not."""
STARTED = re.compile("Arming|Taking off|Forming line|Scanning|Converging|Found")
ORIGIN_DEG = (48.3, 14.3, 260.0)
AREA_ENU_M = ((-25.0, 8.0), (25.0, 8.0), (25.0, 88.0), (-25.0, 88.0))
_CONFIGURATION = """
clock_speed = {speed}
[link]
urls = ["udpin://127.0.0.1:{link_port}"]
[mission]
vehicles = {vehicles}
any_vehicles = true
origin_deg = {origin_deg}
area_enu_m = {area_enu_m}
[preflight]
upload_fence = true
[deadlines]
connect_s = {patience_s}
preflight_s = {patience_s}
capture_s = {capture_s}
search_s = {patience_s}
command_s = {command_s}
takeoff_s = {patience_s}
transfer_s = {patience_s}
land_s = {patience_s}
lost_s = {lost_s}
all_lost_s = {patience_s}
[safety]
max_link_age_s = {max_age_s}
max_position_age_s = {max_age_s}
no_go_enu_m = {no_go_enu_m}
[api]
max_command_age_s = 30
port = {port}
operator_code_file = "{code_file}"
plans_folder = "{folder}/plans"
[record]
folder = "{folder}/missions"
"""
"""What takes real time, such as rendering, has deadlines in real time: the clock's seconds pass faster."""


@dataclass
class Station:
    """What stays when the service is ended and started anew: mission file, ports, the operators' code, the records."""

    folder: Path
    vehicles: int
    no_go_enu_m: tuple[tuple[tuple[float, float], ...], ...] = ()
    area_enu_m: tuple[tuple[float, float], ...] = AREA_ENU_M
    port: int = field(default_factory=lambda: unused_port(socket.SOCK_STREAM))
    link_port: int = field(default_factory=unused_port)
    _starts: int = 0

    @property
    def url(self) -> str:
        """The dashboard's address."""
        return f"http://127.0.0.1:{self.port}/"

    @property
    def mission_folders(self) -> list[Path]:
        """The records, oldest first."""
        return sorted(path for path in (self.folder / "missions").iterdir() if path.is_dir())

    def fly(self, vehicles: int, *options: str, name: str = "vehicles") -> AbstractAsyncContextManager[Program]:
        """Simulate vehicles in a process of their own."""
        link = f"udpout://127.0.0.1:{self.link_port}"
        program = ("sim", "--vehicles", str(vehicles), "--link", link, "--speed", str(SPEED))
        program += ("--errors", "none")
        return running(self.folder / name, *program, *_PATIENT, *options)

    @asynccontextmanager
    async def serve(self) -> AsyncIterator[Program]:
        """Run the service, with a new mission."""
        self._starts += 1
        async with running(self.folder / f"service-{self._starts}", "run", str(self._write_mission())) as program:
            await program.until_logged("Operators sign in there", START_TIMEOUT_S)
            yield program

    @asynccontextmanager
    async def replay(self, mission_folder: Path) -> AsyncIterator[Program]:
        """Show a record at the same address."""
        options = ("--port", str(self.port), "--operator-code-file", str(self._write_code()))
        async with running(self.folder / "replay", "replay", str(mission_folder), *options) as program:
            await program.until_logged("Operators sign in there", START_TIMEOUT_S)
            yield program

    def _write_code(self) -> Path:
        file = self.folder / "code.txt"
        file.write_text(OPERATOR_CODE, encoding="utf-8")
        return file

    def _write_mission(self) -> Path:
        file = self.folder / "mission.toml"
        text = _CONFIGURATION.format(
            speed=SPEED,
            link_port=self.link_port,
            vehicles=self.vehicles,
            origin_deg=list(ORIGIN_DEG),
            area_enu_m=[list(corner) for corner in self.area_enu_m],
            no_go_enu_m=[[list(corner) for corner in zone] for zone in self.no_go_enu_m],
            patience_s=600.0 * SPEED,
            capture_s=60.0 * SPEED,
            command_s=30.0 * SPEED,
            lost_s=10.0 * SPEED,
            max_age_s=5.0 * SPEED,
            port=self.port,
            code_file=self._write_code().as_posix(),
            folder=self.folder.as_posix(),
        )
        file.write_text(text, encoding="utf-8")
        return file


async def sign_in_as_operator(page: Page) -> None:
    """Sign in on an open page."""
    await page.get_by_test_id("sign-in-open").click()
    await sign_in(page, "Ada", OPERATOR_CODE)
    await expect(page.get_by_test_id("observer")).to_have_count(0)


async def launch(page: Page, button: str) -> None:
    """Press a button that starts the mission, until it has started.

    A busy machine may delay a packet until a check fails for a moment, just then: the page says so.
    """
    while True:
        answered = page.get_by_test_id("phase").filter(has_text=STARTED).or_(page.get_by_test_id("results-error"))
        if button == "launch":
            await expect(page.get_by_test_id(button)).to_be_enabled(timeout=FLIGHT_MS)
            await hold(page, button, expect(answered).to_be_visible(timeout=FLIGHT_MS))
        else:
            await page.get_by_test_id(button).click(timeout=FLIGHT_MS)
            await confirm(page)
        await expect(answered).to_be_visible(timeout=FLIGHT_MS)
        if await page.get_by_test_id("phase").filter(has_text=STARTED).count() == 1:
            return
