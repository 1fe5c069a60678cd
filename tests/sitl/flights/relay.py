"""A relay between autopilots and station that can fall silent, as a radio of all vehicles does."""

from __future__ import annotations

import selectors
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_POLL_S = 0.2
_BUFFER = 65_535


class Relay:
    """Hands datagrams on in both directions, each vehicle's by a port of its own; while silent, it drops them."""

    def __init__(self, link: str, behind_port: int) -> None:
        host, port = link.removeprefix("udpin://").split(":")
        self.station_link = f"udpin://{host}:{behind_port}"
        """Link at which the station listens; the autopilots send to ``link``."""
        self._front_address, self._station_address = (host, int(port)), (host, behind_port)
        self._is_over, self._is_silent = threading.Event(), threading.Event()

    @contextmanager
    def running(self) -> Iterator[Relay]:
        """Relay while the context lasts."""
        thread = threading.Thread(target=self._run, daemon=True)
        thread.start()
        try:
            yield self
        finally:
            self._is_over.set()
            thread.join()

    def fall_silent(self, *, silent: bool = True) -> None:
        """Drop everything from now on, or relay again."""
        (self._is_silent.set if silent else self._is_silent.clear)()

    def _run(self) -> None:
        ports: dict[tuple[str, int], socket.socket] = {}
        with (
            selectors.DefaultSelector() as selector,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as front,
        ):
            front.bind(self._front_address)
            selector.register(front, selectors.EVENT_READ)
            while not self._is_over.is_set():
                for key, _ in selector.select(_POLL_S):
                    read = key.fileobj
                    if not isinstance(read, socket.socket):
                        raise TypeError(f"{read} is no socket")
                    data, sender = read.recvfrom(_BUFFER)
                    if read is front and sender not in ports:
                        ports[sender] = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                        ports[sender].bind((self._front_address[0], 0))
                        selector.register(ports[sender], selectors.EVENT_READ, sender)
                    if self._is_silent.is_set():
                        continue
                    if read is front:
                        ports[sender].sendto(data, self._station_address)
                    else:
                        front.sendto(data, key.data)
        for port in ports.values():
            port.close()
