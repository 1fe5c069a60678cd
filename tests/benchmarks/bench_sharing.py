"""Cost of live sharing with TAK: processor time of its process and of the flight's, and the delay of a finding.

    python tests/benchmarks/bench_sharing.py [--vehicles 50] [--seconds 30] [--taky PROGRAM]

The receiver is a server of the tests on this machine, read by the process that flies. With ``--taky`` (PyPI) it is
taky, and events count when another client of taky's, in this process, has them.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import os
import socket
import statistics
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path

from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.sharing import ChannelState, ChannelStatus
from aos_gcs.runtime.processes.sharing_supervisor import open_sharing_process
from aos_gcs.sharing.settings import SharingSettings, TakSettings
from tests.fakes.mission import ScriptedMission
from tests.fakes.program import unused_port
from tests.fakes.sharing import TakServer

_FINDINGS = 15
_CLIENT = (
    b'<event version="2.0" uid="bench" type="a-f-G-U-C" how="h-e" time="2026-11-28T00:00:00Z" '
    b'start="2026-11-28T00:00:00Z" stale="2036-11-28T00:00:00Z"><point lat="48" lon="14" hae="0" ce="1" le="1"/>'
    b'<detail><contact callsign="bench"/><__group name="Cyan" role="Team Member"/></detail></event>'
)
"""Position of a person in the field, by which taky knows its clients."""


def cpu_s(pid: int) -> float:
    """Return the processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def child() -> int:
    """Return the id of the sharing process."""
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        if b"runtime.sharing_process" in path.read_bytes():
            pid = int(path.parent.name)
            stat = (path.parent / "stat").read_text(encoding="ascii").rpartition(")")[2].split()
            if int(stat[1]) == os.getpid():
                return pid
    raise SystemExit("no sharing process")


@contextlib.asynccontextmanager
async def behind_taky(program: str, client: TakServer) -> AsyncIterator[int]:
    """Run taky, and have a client of its keep what it is sent; the port."""
    with tempfile.TemporaryDirectory() as name:
        folder, port = Path(name), unused_port(socket.SOCK_STREAM)
        taky = f"[taky]\nhostname = localhost\nbind_ip = 127.0.0.1\npublic_ip = 127.0.0.1\nroot_dir = {folder}\n"
        rest = f"[cot_server]\nport = {port}\n[dp_server]\nupload_path = {folder}\n[ssl]\nenabled = false\n"
        (folder / "taky.conf").write_text(taky + rest, encoding="utf-8")
        process = await asyncio.create_subprocess_exec(program, "-l", "error", cwd=folder)
        try:
            reader, writer = await _connected(port)
            writer.write(_CLIENT)
            reading = asyncio.create_task(client.serve(reader, writer))
            yield port
            reading.cancel()
        finally:
            process.terminate()
            await process.wait()


async def _connected(port: int) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    for _ in range(100):
        try:
            return await asyncio.open_connection("127.0.0.1", port)
        except OSError:
            await asyncio.sleep(0.1)
    raise SystemExit("taky does not listen")


async def measure(vehicles: int, seconds: float, taky: str | None) -> None:
    """Fly a scripted mission, with and without sharing it."""
    mission, statuses, server = ScriptedMission(LoopClock(), vehicles), list[ChannelStatus](), TakServer()
    listening = server.listening() if taky is None else behind_taky(taky, server)
    flying = asyncio.create_task(mission.run())
    await mission.act(Action.START, None)
    await asyncio.sleep(12.0)
    own = cpu_s(os.getpid())
    await asyncio.sleep(seconds)
    alone_s = cpu_s(os.getpid()) - own
    async with listening as port:
        settings = SharingSettings(TakSettings(f"tcp://127.0.0.1:{port}"))
        async with open_sharing_process(settings, print) as sharing:
            assert sharing is not None
            async with sharing.following(mission, mission, statuses.extend, mission.proposals):
                await server.until(lambda: bool(statuses) and statuses[-1].state is ChannelState.CONNECTED)
                pid = child()
                own, theirs, events = cpu_s(os.getpid()), cpu_s(pid), len(server.events)
                await asyncio.sleep(seconds)
                flight_s, sharing_s = cpu_s(os.getpid()) - own, cpu_s(pid) - theirs
                sent = len(server.events) - events
                delays_s = [await finding_delay_s(mission, server, number) for number in range(_FINDINGS)]
    flying.cancel()
    print(f"{vehicles} vehicles, {seconds:.0f} s, {sent / seconds:.0f} events per second")
    print(f"sharing process: {100.0 * sharing_s / seconds:.1f} % of a core")
    share, alone = (100.0 * spent_s / seconds for spent_s in (flight_s, alone_s))
    print(f"flight's process: {share:.1f} % of a core, without sharing {alone:.1f} %")
    print("  (that includes the server, which parses every event)")
    print(f"finding to server: median {statistics.median(delays_s):.2f} s, longest {max(delays_s):.2f} s")


async def finding_delay_s(mission: ScriptedMission, server: TakServer, number: int) -> float:
    """Mark a place, and return the time until the server has it."""
    await asyncio.sleep(0.61 + 0.07 * number)
    began_s = time.perf_counter()
    found = await mission.add_finding((10.0, 20.0, 0.0), "", operator="Ada")
    uid = f"aos-gcs.scripted-1.finding.{found.finding_id}"
    await server.until(lambda: any(event.get("uid") == uid for event in server.events[-400:]))
    return time.perf_counter() - began_s


def main() -> None:
    """Read the options and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vehicles", type=int, default=50)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--taky", help="Program of taky.")
    options = parser.parse_args()
    asyncio.run(measure(options.vehicles, options.seconds, options.taky))


if __name__ == "__main__":
    main()
