"""The ground station and the cameras of one flight, as processes, and what they tell."""

from __future__ import annotations

import json
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any

from tests.sitl.flights.autopilots import ALTITUDE_AMSL_M, LATITUDE_DEG, LONGITUDE_DEG, PROGRAM, Kind

CODE = "sitl-flights-0000"
VEHICLES = 3
ORIGIN = f"{LATITUDE_DEG},{LONGITUDE_DEG},{ALTITUDE_AMSL_M}"
STOP_S = 30.0

_MISSION = """
[link]
urls = ["{link}"]

[mission]
vehicle_ids = [1, 2, 3]
origin_deg = [{origin}]
area_enu_m = {area_enu_m}
auto_start = {auto_start}
auto_return = true

[flight]
lowest_layer_m = 35.0
layer_spacing_m = {spacing_m}
cruise_speed_mps = 5.0

[preflight]
upload_fence = true
{preflight}

[record]
folder = "missions"

{tables}
"""


@dataclass(frozen=True)
class Setting:
    """Search area of a flight, and what its cameras see there."""

    area_enu_m: tuple[tuple[float, float], ...] = ((-10.0, 30.0), (10.0, 30.0), (10.0, 75.0), (-10.0, 75.0))
    world: tuple[str, ...] = ()
    """More options of the simulated world, for ``sim`` and for ``sim-camera``."""
    terrain: str | None = None
    """Shape of the ground, above which the layers follow it; None: it is level."""
    tables: str = ""
    """More tables of the mission's file."""
    overrides: tuple[str, ...] = ()
    """Checks that fail and are overridden, each with its reason."""

    @property
    def preflight(self) -> str:
        """More lines of its table ``preflight``."""
        follows = () if self.terrain is None else ("climb of the return: simulated vehicles",)
        lines = () if self.terrain is None else ("set_return_height = true",)
        return "\n".join((*lines, f"overrides = {json.dumps([*follows, *self.overrides])}"))


RELIEF_FILE = "ground.tif"
FLOOR_M = 25.0
"""Floor above the ground of flights over a relief."""
TERRAIN = f"""
[terrain]
files = ["{RELIEF_FILE}"]
kind = "terrain"
floor_above_ground_m = {FLOOR_M}
follow = true
"""


def mission_file(kind: Kind, setting: Setting, *, auto_start: bool = True, link: str | None = None) -> str:
    """Configuration of the service that flies ``setting`` with autopilots of ``kind``, which it hears at ``link``."""
    return _MISSION.format(
        link=link or kind.station_link,
        origin=ORIGIN.replace(",", ", "),
        spacing_m=kind.layer_spacing_m,
        auto_start=str(auto_start).lower(),
        area_enu_m=[list(corner) for corner in setting.area_enu_m],
        preflight=setting.preflight,
        tables=setting.tables + ("" if setting.terrain is None else TERRAIN),
    )


class FlightError(Exception):
    """The flight did not come to what was waited for."""


@dataclass
class Station:
    """Service and cameras in a folder of their own."""

    kind: Kind
    folder: Path
    deadline_s: float
    """Monotonic time at which the flight is given up."""
    setting: Setting = Setting()
    """Read when the context is entered, and by :meth:`start`."""
    by_hand: bool = False
    """Whether an operator launches, and not the station as soon as preflight has passed."""
    link: str | None = None
    """Link at which it listens; None: that to which the autopilots send."""
    _service: subprocess.Popen[bytes] | None = None
    _cameras: subprocess.Popen[bytes] | None = None
    _starts: int = 0

    def __post_init__(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        self._opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
        (self.folder / "code").write_text(CODE, encoding="utf-8")

    def __enter__(self) -> Station:
        links = [part for link in self.kind.camera_links(VEHICLES) for part in ("--link", link)]
        files = ["--world-file", "world.json", "--report-file", "report.json"]
        world = ["--origin", ORIGIN, *self.setting.world]
        if self.setting.terrain is not None:
            world += ["--terrain", self.setting.terrain]
            writing = self._run("sim.log", "sim", *world, "--terrain-file", RELIEF_FILE, "--terrain-only")
            if writing.wait(STOP_S) != 0:
                raise FlightError(f"no ground: see {self.folder / 'sim.log'}")
        self._cameras = self._run(
            "cameras.log", "sim-camera", *links, *world, "--image-size", "256", "--errors", "none", *files
        )
        self.start(auto_start=not self.by_hand)
        return self

    def __exit__(self, *_: object) -> None:
        for process in (self._service, self._cameras):
            if process is not None:
                _end(process)

    def start(self, *, auto_start: bool = True) -> None:
        """Start the service."""
        self._starts += 1
        text = mission_file(self.kind, self.setting, auto_start=auto_start, link=self.link)
        (self.folder / "mission.toml").write_text(text, encoding="utf-8")
        arguments = ["mission.toml", "--port", str(self.kind.api_port), "--operator-code-file", "code"]
        self._service = self._run(f"service-{self._starts}.log", "run", *arguments)

    def kill(self) -> None:
        """End the service as a crash would."""
        if self._service is not None:
            self._service.kill()
            self._service.wait()

    def _run(self, log: str, *arguments: str) -> subprocess.Popen[bytes]:
        with (self.folder / log).open("wb") as output:
            return subprocess.Popen(  # noqa: S603 - our own program
                [*PROGRAM, *arguments],
                cwd=self.folder,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    # --- what the service tells ----------------------------------------------------------------------------------

    def state(self) -> dict[str, Any] | None:
        """Return the mission, or None while the service does not answer."""
        try:
            return dict(json.loads(self._request("/api/mission")[0]))
        except (OSError, ValueError):
            return None

    def wait_for(self, what: str, condition: Callable[[dict[str, Any]], bool], within_s: float) -> dict[str, Any]:
        """Return the first state that meets a condition.

        Raises:
            FlightError: none did in time.
        """
        end_s = min(time.monotonic() + within_s, self.deadline_s)
        state = None
        while time.monotonic() < end_s:
            state = self.state()
            if state is not None and condition(state):
                return state
            time.sleep(0.5)
        raise FlightError(f"{what}: not within {within_s:.0f} s; {describe(state)}")

    def act(self, action: str, *vehicle_ids: int) -> list[str]:
        """Carry out an operator's action, for these vehicles or for all; return the refusals."""
        self._request("/api/session", {"code": CODE, "name": "flights"})
        _, headers = self._request("/api/mission")
        body = {"action": action, "vehicle_ids": list(vehicle_ids) or None}
        answer, _ = self._request("/api/mission/actions", body, {"X-Seen": headers["X-Seen"]})
        return [f"{row['vehicle_id']}: {row['text']}" for row in json.loads(answer)["results"] if not row["accepted"]]

    def _request(
        self, path: str, body: dict[str, Any] | None = None, headers: dict[str, str] | None = None
    ) -> tuple[bytes, Any]:
        data = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json", **(headers or {})}
        request = urllib.request.Request(f"http://127.0.0.1:{self.kind.api_port}{path}", data, headers)
        try:
            with self._opener.open(request, timeout=10.0) as answer:
                return answer.read(), answer.headers
        except urllib.error.HTTPError as error:
            raise FlightError(f"{path}: {error.code} {error.read().decode(errors='replace')}") from error

    # --- what the records tell -------------------------------------------------------------------------------------

    def truth(self, figure: str) -> float | None:
        """Return a figure of the cameras' report, such as the smallest true distance of two vehicles in the air."""
        try:
            report = json.loads((self.folder / "report.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        value = report.get(figure)
        return None if value is None else float(value)

    def said(self, text: str) -> list[str]:
        """Return the lines with a text in what all services of this flight have logged."""
        logs = [path.read_text(encoding="utf-8") for path in sorted(self.folder.glob("service-*.log"))]
        return [line for log in logs for line in log.splitlines() if text in line]

    def ask(self, log: str, *arguments: str) -> str:
        """Have the program report on the last mission of this flight, and keep what it says in a file."""
        folder = max((self.folder / "missions").iterdir())
        answer = self._run(log, *(part.replace("MISSION", str(folder)) for part in arguments))
        if answer.wait(2 * STOP_S) != 0:
            raise FlightError(f"{' '.join(arguments)}: see {self.folder / log}")
        return (self.folder / log).read_text(encoding="utf-8")


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def describe(state: dict[str, Any] | None) -> str:
    """Return where a mission stands, in a line."""
    if state is None:
        return "the service did not answer"
    failed = [f"{row['name']} ({row['vehicle_id']}): {row['text']}" for row in failures(state)]
    vehicles = ", ".join(f"{v['vehicle_id']} {v['task']} {v['mode_name']}" for v in state["vehicles"])
    return f"{state['phase']} {state['suspension']} {state['message']}; {vehicles}; {'; '.join(failed)}"


def failures(state: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the failed checks."""
    return [row for row in state["preflight"] if row["status"] == "fail"]


def all_down(state: dict[str, Any]) -> bool:
    """Whether every vehicle of the mission reports to stand, disarmed."""
    flying = [v for v in state["vehicles"] if v["takes_part"]]
    return bool(flying) and all(v["landed"] == "on_ground" and v["armed"] is False for v in flying)
