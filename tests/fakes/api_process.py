"""A scripted mission in this process, with the dashboard in another one."""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ApiConfig
from aos_gcs.ports import Notice
from aos_gcs.runtime.dashboard.start import ApiStart
from aos_gcs.runtime.dashboard.supervisor import open_api_process
from tests.fakes.mission import ScriptedMission
from tests.timing import scaled_s

CODE = "larch-and-spruce"
_PROGRAMS = ("aos_gcs.runtime.dashboard.process", "tests.fakes.spinning_api")
"""Main programs of the dashboard's process, the latter with a defect."""


@dataclass
class Station:
    """The mission, and what operators were told."""

    mission: ScriptedMission
    url: str = ""
    notices: list[Notice] = field(default_factory=list)

    def take(self, notice: Notice) -> None:
        self.notices.append(notice)
        self.mission.notify(notice.severity, notice.text)

    async def until_told(self, text: str, count: int = 1) -> None:
        async with asyncio.timeout(scaled_s(60.0)):
            while sum(text in notice.text for notice in self.notices) < count:  # noqa: ASYNC110 - nothing announces it
                await asyncio.sleep(0.05)

    async def process_id(self) -> int:
        """Return the id of the dashboard's process."""
        listing = await asyncio.create_subprocess_exec(
            "ps", "-A", "-ww", "-o", "pid=,ppid=,args=", stdout=asyncio.subprocess.PIPE
        )
        output, _ = await listing.communicate()
        rows = (line.split(maxsplit=2) for line in output.decode().splitlines())
        own = ((int(pid), line) for pid, parent, line in rows if int(parent) == os.getpid())
        (found,) = (pid for pid, line in own if any(name in line for name in _PROGRAMS))
        return found


@asynccontextmanager
async def station(folder: Path, **options: str) -> AsyncIterator[Station]:
    """Fly a mission, and show it in another process."""
    mission = ScriptedMission(LoopClock())
    flown = Station(mission)
    config = ApiConfig(port=0, plans_folder=folder / "plans")
    start = ApiStart(config, CODE, folder, folder / "m")
    async with open_api_process(start, flown.take, **options) as api:
        assert api is not None
        flying = asyncio.create_task(mission.run())
        async with api.showing(mission, mission):
            flown.url = api.address.url
            yield flown
        flying.cancel()
