"""Keys of all links, and the regular storage of the times up to which they have been used."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType

from aos_drivers.links.address import LinkAddress
from aos_drivers.mavlink.signing.key_file import (
    read_key,
    read_streams,
    read_ticks,
    streams_file_of,
    time_file_of,
    write_streams,
    write_ticks,
)
from aos_drivers.mavlink.signing.signer import TICKS_PER_S, LinkSigner, SigningClock, StreamMemory
from aos_gcs.errors import ConfigurationError
from aos_gcs.ports import Clock

_STORE_PERIOD_S = 1.0
"""After a crash, packets of this time might be accepted again."""
_LEAD_TICKS = round(2 * _STORE_PERIOD_S * TICKS_PER_S)
"""Margin by which stored times are ahead, so that a restart after a crash never reuses a time."""


class Keyring:
    """The signers of the links that have a key.

    Links with the same key file share its clock, those with the same key its memory of senders.
    """

    def __init__(self, addresses: Sequence[LinkAddress], clock: Clock) -> None:
        """Read the keys and store their times; waits for the disk.

        Raises:
            ConfigurationError: a key cannot be used, or its time cannot be stored beside it.
        """
        self._clock = clock
        self._clocks: dict[Path, SigningClock] = {}
        self._memories: dict[Path, StreamMemory] = {}
        self._stored_changes: dict[Path, int] = {}
        self._lock = threading.Lock()
        memories: dict[bytes, StreamMemory] = {}
        signers: dict[int, LinkSigner] = {}
        for link, address in enumerate(addresses):
            if address.signing is not None:
                path = address.signing.key_file
                key = read_key(path)
                if path not in self._clocks:
                    self._clocks[path] = SigningClock(clock.utc_s, read_ticks(time_file_of(path)))
                    stored = read_streams(streams_file_of(path))
                    self._memories[path] = memories.setdefault(key, StreamMemory(stored))
                    self._stored_changes[path] = 0
                signers[link] = LinkSigner(
                    link, key, self._clocks[path], address.signing.accepts_unsigned, self._memories[path]
                )
        self.signers: Mapping[int, LinkSigner] = MappingProxyType(signers)
        """Signers by number of the link."""
        try:
            self._store(_LEAD_TICKS)
        except OSError as error:
            raise ConfigurationError(
                f"{error.filename} cannot be written: {error.strerror}; the time of a key is stored beside it"
            ) from error

    async def run(self) -> None:
        """Store the times until cancelled. A full disk has no effect before the next start."""
        while self._clocks:
            await self._clock.sleep(_STORE_PERIOD_S)
            with suppress(OSError):
                await asyncio.to_thread(self._store, _LEAD_TICKS)

    def close(self) -> None:
        """Store the last time that was used; waits for the disk."""
        with suppress(OSError):
            self._store(0)

    def _store(self, lead_ticks: int) -> None:
        with self._lock:
            for path, clock in self._clocks.items():
                write_ticks(time_file_of(path), clock.now_ticks() + lead_ticks)
                memory = self._memories[path]
                if memory.changes != self._stored_changes[path]:
                    changes, latest_ticks = memory.changes, dict(memory.latest_ticks)
                    write_streams(streams_file_of(path), latest_ticks)
                    self._stored_changes[path] = changes
