"""The other side of live sharing: states of a scripted mission, a TAK server, and certificates."""

from __future__ import annotations

import asyncio
import subprocess
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.state import SeenState
from tests.fakes.mission import ScriptedMission

UTC_S = 1_795_000_000.0


class StillClock:
    """A clock that stands still, for states of a mission outside of an event loop."""

    speed = 1.0

    def now_s(self) -> float:
        return 0.0

    def utc_s(self) -> float:
        return UTC_S

    async def sleep(self, duration_s: float) -> None:
        raise NotImplementedError

    def timeout_at(self, deadline_s: float) -> asyncio.Timeout:
        raise NotImplementedError


@asynccontextmanager
async def running(work: Coroutine[Any, Any, None]) -> AsyncIterator[None]:
    """Do work, such as that of a channel, for as long as the context is entered."""
    task = asyncio.create_task(work)
    try:
        yield
    finally:
        task.cancel()
        await asyncio.wait({task})


def scripted(vehicles: int = 2) -> MissionSnapshot:
    """Return the state of a scripted mission that has not started."""
    return ScriptedMission(StillClock(), vehicles).snapshot()


def parsed(event: bytes) -> ET.Element:
    """Return an event of ours."""
    return ET.fromstring(event)  # noqa: S314


def seen(snapshot: MissionSnapshot | None = None, published_at_s: float = 0.0) -> SeenState:
    """Return a state, that of a mission which has not started if none is given."""
    return SeenState(snapshot or scripted(), published_at_s)


@dataclass
class TakServer:
    """Keeps the events of all connections, and answers pings; it reads nothing while it is paused."""

    utc_s: Callable[[], float] | None = None
    """Clock of its answers; None: it answers nothing."""
    events: list[ET.Element] = field(default_factory=list)
    is_paused: bool = False
    connections: int = 0
    marks: bytes = b""
    """What each new client is sent at once, as servers send what others have drawn."""

    def uids(self) -> list[str]:
        return [event.get("uid", "") for event in self.events]

    async def until(self, condition: Callable[[], bool]) -> None:
        while not condition():  # noqa: ASYNC110 - nothing announces it
            await asyncio.sleep(0.02)

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.connections += 1
        writer.write(self.marks)
        rest = b""
        try:
            while True:
                while self.is_paused:  # noqa: ASYNC110 - nothing announces it
                    await asyncio.sleep(0.05)
                data = await reader.read(65_536)
                if not data:
                    break
                *events, rest = (rest + data).split(b"</event>")
                for event in events:
                    self._take(parsed(event + b"</event>"), writer)
        except OSError:
            pass
        finally:
            writer.transport.abort()

    def _take(self, event: ET.Element, writer: asyncio.StreamWriter) -> None:
        if event.get("type") != "t-x-c-t":
            self.events.append(event)
        elif self.utc_s is not None:
            time = datetime.fromtimestamp(self.utc_s(), UTC).isoformat().replace("+00:00", "Z")
            writer.write(f'<?xml version="1.0"?><event uid="pong" type="t-x-c-t-r" time="{time}"></event>'.encode())

    @asynccontextmanager
    async def listening(self, port: int = 0, **options: object) -> AsyncIterator[int]:
        """Listen until the context is left, which breaks off all connections."""
        tasks: set[asyncio.Task[None]] = set()

        async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            task = asyncio.current_task()
            assert task is not None
            tasks.add(task)
            with suppress(asyncio.CancelledError):  # which asyncio would log as an error of this connection
                await self.serve(reader, writer)

        server = await asyncio.start_server(serve, "127.0.0.1", port, **options)  # type: ignore[arg-type]
        try:
            yield server.sockets[0].getsockname()[1]
        finally:
            server.close()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)


def make_authority(folder: Path, name: str) -> Path:
    """Make the key and the certificate of an authority; return the certificate."""
    _openssl("req", "-x509", *_NEW_KEY, folder / f"{name}.key", "-out", folder / f"{name}.pem", "-subj", f"/CN={name}")
    return folder / f"{name}.pem"


def make_certificate(folder: Path, authority: str, name: str, days: int = 30) -> tuple[Path, Path]:
    """Make a certificate for 127.0.0.1 that an authority has signed; return it and its key."""
    request, key, certificate = (folder / f"{name}.{suffix}" for suffix in ("csr", "key", "pem"))
    _openssl("req", *_NEW_KEY, key, "-out", request, "-subj", f"/CN={name}")
    (folder / "names.txt").write_text("subjectAltName=IP:127.0.0.1\n", encoding="ascii")
    signed_by = ("-CA", folder / f"{authority}.pem", "-CAkey", folder / f"{authority}.key", "-CAcreateserial")
    extensions = ("-extfile", folder / "names.txt", "-days", days)
    _openssl("x509", "-req", "-in", request, *signed_by, *extensions, "-out", certificate)
    return certificate, key


_NEW_KEY = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout")


def _openssl(*arguments: object) -> None:
    subprocess.run(["openssl", *map(str, arguments)], check=True, capture_output=True)  # noqa: S603, S607
