"""A serial device, such as a telemetry radio, as an endpoint."""

from __future__ import annotations

import asyncio
import errno
import os
import termios
from collections.abc import Callable

import serial

from aos_drivers.links.address import LinkAddress, PeerAddress
from aos_gcs.errors import LinkError

_READ_BYTES = 4096
_UNSENT_BYTES = 2048
"""Size of the send buffer: a third of a second at 57600 baud; packets that wait longer are outdated."""


class SerialEndpoint:
    """One serial device. It may vanish (a pulled plug) and be opened again."""

    def __init__(self, link: int, address: LinkAddress, receive: Callable[[bytes, PeerAddress], None]) -> None:
        self.peer = PeerAddress(link, address.host, address.port)
        self._receive = receive
        self._port: serial.Serial | None = None
        self._unsent = bytearray()
        self._is_lost = asyncio.Event()

    def open(self) -> None:
        """Open the device exclusively, and pass on the bytes that it receives.

        Raises:
            OSError: it does not exist, is in use or may not be opened.
        """
        try:
            port = serial.Serial(self.peer.host, self.peer.port, timeout=0, write_timeout=0, exclusive=True)
        except termios.error as error:  # it vanished while it was opened
            raise OSError(*error.args) from error
        except ValueError as error:
            raise OSError(errno.EINVAL, f"{error}; choose a baud rate that the device has") from error
        self._port = port
        self._is_lost.clear()
        asyncio.get_running_loop().add_reader(port.fileno(), self._read, port.fileno())

    def close(self) -> None:
        """Close the device, if it is open."""
        if self._port is not None:
            loop = asyncio.get_running_loop()
            loop.remove_reader(self._port.fileno())
            loop.remove_writer(self._port.fileno())
            self._port.close()
            self._port = None
        self._unsent.clear()
        self._is_lost.set()

    async def wait_until_lost(self) -> None:
        """Return when the device has vanished."""
        await self._is_lost.wait()

    def send(self, data: bytes, peer: PeerAddress) -> None:
        """See Endpoint. Policy when the line is too slow: the packet is lost as a whole, never in parts."""
        del peer
        if self._port is not None and len(self._unsent) + len(data) <= _UNSENT_BYTES:
            self._unsent += data
            self._write(self._port.fileno())

    def _read(self, number: int) -> None:
        try:
            data = os.read(number, _READ_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self._receive(data, self.peer)
        else:
            self.close()

    def _write(self, number: int) -> None:
        try:
            del self._unsent[: os.write(number, self._unsent)]
        except BlockingIOError:
            pass  # the line is busy; the rest is written when it is free
        except OSError:
            self.close()
            return
        loop = asyncio.get_running_loop()
        if self._unsent:
            loop.add_writer(number, self._write, number)
        else:
            loop.remove_writer(number)


def serial_error(address: LinkAddress, error: OSError) -> LinkError:
    """Return the error of a device that cannot be opened, with the remedy."""
    device = address.host
    match error.errno:
        case errno.ENOENT | errno.ENODEV | errno.ENXIO:
            return LinkError(f"{device} does not exist: connect the radio, or find its name in /dev/serial/by-id")
        case errno.EACCES:
            return LinkError(
                f"no permission to open {device}: add your user to its group (often dialout) and log in again"
            )
        case errno.EAGAIN | errno.EBUSY:
            return LinkError(f"{device} is in use: stop the other ground station")
    return LinkError(f"{address.text} cannot be opened: {error.strerror or error}")
