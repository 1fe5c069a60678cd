"""Cost of live sharing with TAK: processor time of its process and of the flight's, and the delay of a finding.

    python tests/benchmarks/bench_sharing.py [--vehicles 50] [--seconds 30]

The receiver is a server of the tests on this machine, read by the process that flies.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import statistics
import time
from pathlib import Path

from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.sharing import ChannelState, ChannelStatus
from aos_gcs.runtime.sharing_supervisor import open_sharing_process
from aos_gcs.sharing.settings import SharingSettings, TakSettings
from tests.fakes.mission import ScriptedMission
from tests.fakes.sharing import TakServer

_FINDINGS = 15


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


async def measure(vehicles: int, seconds: float) -> None:
    """Fly a scripted mission, with and without sharing it."""
    mission, statuses, server = ScriptedMission(LoopClock(), vehicles), list[ChannelStatus](), TakServer()
    flying = asyncio.create_task(mission.run())
    await mission.act(Action.START, None)
    await asyncio.sleep(12.0)
    own = cpu_s(os.getpid())
    await asyncio.sleep(seconds)
    alone_s = cpu_s(os.getpid()) - own
    async with server.listening() as port:
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
    options = parser.parse_args()
    asyncio.run(measure(options.vehicles, options.seconds))


if __name__ == "__main__":
    main()
