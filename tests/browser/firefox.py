"""Firefox, driven by WebDriver BiDi, which it speaks itself: it needs neither a driver program nor another build."""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import re
import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

from tests.timing import scaled_s

NAMES = ("firefox-esr", "firefox")
TIMEOUT_S = scaled_s(20.0)
START_TIMEOUT_S = scaled_s(60.0)
LARGEST_MESSAGE = 64 * 1024 * 1024
_ADDRESS = re.compile(rb"WebDriver BiDi listening on (ws://\S+)")
_PREFERENCES = {
    "app.normandy.enabled": False,
    "app.update.enabled": False,
    "browser.shell.checkDefaultBrowser": False,
    "browser.startup.page": 0,
    "browser.startup.homepage_override.mstone": "ignore",
    "datareporting.policy.dataSubmissionEnabled": False,
    "extensions.update.enabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "services.settings.server": "data:,#remote-settings-dummy",
    "toolkit.telemetry.enabled": False,
}
"""Nothing is asked of the internet."""
_STILL_PLACE = """async find => {
    for (let before = null, frame = 0; frame < 10; frame++) {
        const element = find();
        if (!element || element.disabled) return null;
        element.scrollIntoView({ block: "nearest" });
        const { x, y, width, height } = element.getBoundingClientRect();
        const place = [Math.round(x + width / 2), Math.round(y + height / 2)];
        if (`${place}` === before && element.contains(document.elementFromPoint(...place))) return place;
        before = `${place}`;
        await new Promise(requestAnimationFrame);
    }
    return null;
}"""
"""Returns the middle of an element once a press would meet it: it is there, stands still, and nothing lies above it."""


class FirefoxError(AssertionError):
    """What Firefox has refused, or has not done in time."""


class Firefox:
    """One tab of a Firefox, with what the tests do in it."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._numbers = itertools.count(1)
        self._context = ""
        self.errors: list[str] = []
        """What the page has complained about."""

    async def begin(self) -> None:
        """Open the session and its tab."""
        await self._send("session.new", {"capabilities": {}})
        await self._send("session.subscribe", {"events": ["log.entryAdded"]})
        tree = await self._send("browsingContext.getTree", {})
        self._context = tree["contexts"][0]["context"]
        await self._send(
            "browsingContext.setViewport", {"context": self._context, "viewport": {"width": 1280, "height": 800}}
        )

    async def open(self, url: str) -> None:
        """Load a page."""
        await self._send("browsingContext.navigate", {"context": self._context, "url": url, "wait": "complete"})

    async def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression, which may be a promise, by JSON."""
        wrapped = f"(async () => JSON.stringify((await ({expression})) ?? null))()"
        answer = await self._send(
            "script.evaluate",
            {"expression": wrapped, "target": {"context": self._context}, "awaitPromise": True},
        )
        if answer["type"] != "success":
            raise FirefoxError(answer["exceptionDetails"]["text"])
        return json.loads(answer["result"]["value"])

    async def until(self, expression: str) -> Any:
        """Wait until an expression is true, and return its value."""
        deadline_s = asyncio.get_running_loop().time() + TIMEOUT_S
        while not (value := await self.evaluate(expression)):
            if asyncio.get_running_loop().time() > deadline_s:
                text = await self.evaluate("document.body.innerText")
                raise FirefoxError(f"not within {TIMEOUT_S:.0f} s: {expression}\n{self.errors}\n{text}")
            await asyncio.sleep(0.1)
        return value

    async def until_text(self, test_id: str, text: str) -> None:
        """Wait until an element contains a text."""
        await self.until(f"{_element(test_id)}?.textContent.includes({json.dumps(text)})")

    async def press(self, test_id: str, *, hold: str | None = None) -> None:
        """Click an element with the mouse, or keep the button pressed until an expression is true."""
        x_px, y_px = await self.until(f"({_STILL_PLACE})(() => {_element(test_id)})")
        await self.press_at(x_px, y_px, hold=hold)

    async def press_at(self, x_px: int, y_px: int, *, hold: str | None = None) -> None:
        """Click a place of the page."""
        await self._mouse({"type": "pointerMove", "x": x_px, "y": y_px}, {"type": "pointerDown", "button": 0})
        if hold is not None:
            await self.until(hold)
        await self._mouse({"type": "pointerUp", "button": 0})

    async def fill(self, test_id: str, text: str) -> None:
        """Type into a field."""
        await self.press(test_id)
        await self.type(text)

    async def type(self, text: str) -> None:
        """Press keys."""
        keys = [{"type": kind, "value": key} for key in text for kind in ("keyDown", "keyUp")]
        source = {"type": "key", "id": "keyboard", "actions": keys}
        await self._send("input.performActions", {"context": self._context, "actions": [source]})

    async def _mouse(self, *actions: dict[str, Any]) -> None:
        source = {"type": "pointer", "id": "mouse", "actions": list(actions)}
        await self._send("input.performActions", {"context": self._context, "actions": [source]})

    async def _send(self, method: str, params: dict[str, Any]) -> Any:
        number = next(self._numbers)
        await self._connection.send(json.dumps({"id": number, "method": method, "params": params}))
        async with asyncio.timeout(START_TIMEOUT_S):
            while True:
                message = json.loads(await self._connection.recv())
                if message.get("method") == "log.entryAdded" and message["params"]["level"] == "error":
                    self.errors.append(str(message["params"]["text"]))
                if message.get("id") != number:
                    continue
                if message["type"] == "error":
                    raise FirefoxError(f"{method}: {message['error']}: {message['message']}")
                return message["result"]


def _element(test_id: str) -> str:
    return f"document.querySelector('[data-testid=\"{test_id}\"]')"


def firefox_path() -> str | None:
    """The browser named by AOS_GCS_FIREFOX, else the first one installed."""
    candidates = (os.environ.get("AOS_GCS_FIREFOX"), *map(shutil.which, NAMES))
    return next((path for path in candidates if path and shutil.which(path)), None)


@asynccontextmanager
async def running_firefox(path: str, profile: Path) -> AsyncIterator[Firefox]:
    """Run a Firefox with an empty profile for as long as the context is entered."""
    await asyncio.to_thread(_make_profile, profile)
    command = ("--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0", "about:blank")
    environment = {**os.environ, "HOME": str(profile), "MOZ_HEADLESS": "1"}
    process = await asyncio.create_subprocess_exec(
        path, *command, env=environment, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE
    )
    draining: asyncio.Task[None] | None = None
    try:
        async with asyncio.timeout(START_TIMEOUT_S):
            address = await _address(process)
        draining = asyncio.create_task(_drain(process))
        async with connect(f"{address}/session", max_size=LARGEST_MESSAGE) as connection:
            firefox = Firefox(connection)
            await firefox.begin()
            yield firefox
    finally:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()
        if draining is not None:
            await draining


def _make_profile(folder: Path) -> None:
    folder.mkdir(parents=True)
    lines = (f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in _PREFERENCES.items())
    (folder / "user.js").write_text("".join(lines), encoding="utf-8")


async def _address(process: asyncio.subprocess.Process) -> str:
    assert process.stderr is not None
    read: list[bytes] = []
    while line := await process.stderr.readline():
        read.append(line)
        if found := _ADDRESS.search(line):
            return found.group(1).decode()
    raise FirefoxError(f"Firefox has not started: {b''.join(read).decode(errors='replace')}")


async def _drain(process: asyncio.subprocess.Process) -> None:
    assert process.stderr is not None
    while await process.stderr.readline():
        pass
