"""Main program of live sharing's process: sees a mission that flies in another process, and ends with that one."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import sys
from dataclasses import asdict, dataclass, field
from typing import Final

from aos_gcs.bridge.mirror import MissionMirror
from aos_gcs.clock import machine_utc_s
from aos_gcs.runtime.processes.follower import Alive, run_follower
from aos_gcs.sharing.service import make_channels, share
from aos_gcs.sharing.settings import SharingSettings

_MEMORY_BYTES: Final = 2**30


@dataclass(frozen=True, slots=True)
class SharingStart:
    """Settings of the process."""

    settings: SharingSettings
    log_level: int = field(default_factory=lambda: logging.getLogger().getEffectiveLevel())

    def to_json(self) -> bytes:
        """Return all of it as JSON."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_json(cls, text: bytes) -> SharingStart:
        """Return what :meth:`to_json` has written."""
        fields = json.loads(text)
        return cls(SharingSettings.from_tables(fields["settings"]), fields["log_level"])


def main(arguments: list[str]) -> None:
    """Share until the flight's process is gone.

    Args:
        arguments: file descriptors of the connection to it and of the lifeline.
    """
    control_fd, lifeline_fd = map(int, arguments)
    run_follower(control_fd, lifeline_fd, _MEMORY_BYTES, SharingStart.from_json, _work)


async def _work(mirror: MissionMirror, start: SharingStart, alive: Alive) -> None:
    await mirror.greeted()
    channels = make_channels(start.settings, os.environ, asyncio.get_running_loop().time, machine_utc_s)
    alive.begin_to_serve()
    await share(mirror, channels, machine_utc_s)


if __name__ == "__main__":
    main(sys.argv[1:])
