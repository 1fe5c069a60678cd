"""Connections to TAK: datagrams, a stream, or a stream with certificates. None of them ever holds more than a batch."""

from __future__ import annotations

import asyncio
import ipaddress
import socket
import ssl
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol, cast

from aos_gcs.errors import ConfigurationError
from aos_gcs.sharing.channel import ChannelError
from aos_gcs.sharing.settings import TakSettings, TakTransport

CONNECT_S = 8.0
"""Longest time for connecting."""
TAKE_S = 5.0
"""Longest time in which the server has to take what is sent."""
_WRITE_AHEAD_BYTES = 65_536
_READ_BYTES = 65_536
_MULTICAST_TTL = 1


class Connection(Protocol):
    """An open connection."""

    answers: bool
    """Whether the other side can answer at all."""

    async def send(self, events: Sequence[bytes]) -> int:
        """Send events, and return how many were sent.

        Raises:
            ChannelError: the connection is lost.
        """
        ...

    async def receive(self) -> bytes:
        """Wait for bytes.

        Raises:
            ChannelError: the connection is lost.
        """
        ...

    async def close(self) -> None:
        """Close it."""
        ...


class Datagrams:
    """Sends events to a multicast group or one receiver; what the system cannot take at once is dropped.

    Args:
        address: host and port.
        interface: address of the network interface for multicast; None: the system's choice.
        receive: whether to join the group, and to hear what others send to it.
    """

    answers = False

    def __init__(self, address: tuple[str, int], interface: str | None, *, receive: bool = False) -> None:
        self._listening: socket.socket | None = None
        family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            if family is socket.AF_INET and ipaddress.ip_address(address[0]).is_multicast:
                self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, _MULTICAST_TTL)
                if interface is not None:
                    own = socket.inet_aton(interface)
                    self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, own)
            self._socket.connect(address)
            self._listening = _member(address, interface) if receive else None
        except OSError:
            self._socket.close()
            raise

    async def send(self, events: Sequence[bytes]) -> int:
        """Send what the system takes at once."""
        count = 0
        for event in events:
            try:
                self._socket.send(event)
            except BlockingIOError:
                break
            except ConnectionRefusedError:
                raise ChannelError("Nobody receives at this address; check it, or start the receiver.") from None
            except OSError as error:
                raise ChannelError(f"The network takes no message: {error.strerror}.") from error
            count += 1
        return count

    async def receive(self) -> bytes:
        """Wait for a datagram of the group; for ever unless this is a member of it."""
        if self._listening is None:
            await asyncio.Event().wait()
            return b""
        try:
            return await asyncio.get_running_loop().sock_recv(self._listening, _READ_BYTES)
        except OSError as error:
            raise ChannelError(f"The network gives no message: {error.strerror}.") from error

    async def close(self) -> None:
        """Close the sockets."""
        self._socket.close()
        if self._listening is not None:
            self._listening.close()


def _member(address: tuple[str, int], interface: str | None) -> socket.socket:
    """Return a socket that hears what is sent to a multicast group, beside other programs of this machine."""
    listening = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        listening.setblocking(False)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if hasattr(socket, "SO_REUSEPORT"):
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        # Bound to the group where the system can: else all that is sent to this port would be heard.
        listening.bind(("" if sys.platform == "win32" else address[0], address[1]))
        own = socket.inet_aton(interface or "0.0.0.0")  # noqa: S104 - stands for any interface
        listening.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(address[0]) + own)
    except OSError:
        listening.close()
        raise
    return listening


class Stream:
    """Sends events over TCP, with or without TLS."""

    answers = True

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader = reader
        self._writer = writer
        self._is_silent = writer.get_extra_info("ssl_object") is not None
        """Whether the other side has presented a certificate and nothing else so far."""
        writer.transport.set_write_buffer_limits(high=_WRITE_AHEAD_BYTES)

    async def send(self, events: Sequence[bytes]) -> int:
        """Send all, and wait until the server has taken most of it."""
        try:
            self._writer.write(b"".join(events))
            async with asyncio.timeout(TAKE_S):
                await self._writer.drain()
        except TimeoutError:
            text = f"The server has taken nothing for {TAKE_S:.0f} s; it is overloaded, or stands still."
            raise ChannelError(text) from None
        except OSError as error:
            raise self._lost(error) from error
        return len(events)

    async def receive(self) -> bytes:
        """Wait for bytes of the server."""
        try:
            data = await self._reader.read(_READ_BYTES)
        except OSError as error:
            raise self._lost(error) from error
        if not data:
            raise self._lost(None)
        self._is_silent = False
        return data

    async def close(self) -> None:
        """Drop the connection, and what the server has not taken."""
        self._writer.transport.abort()
        with suppress(OSError):
            await self._writer.wait_closed()

    def _lost(self, error: OSError | None) -> ChannelError:
        """Return why the connection has ended; without an error the server has closed it."""
        if isinstance(error, ssl.SSLError):
            return tls_error(error)
        if self._is_silent:
            text = "The server has closed the connection without a word; check that it accepts our certificate."
            return ChannelError(text, is_refused=True)
        return ChannelError("The server has closed the connection." if error is None else reason_text(error))


async def connect(settings: TakSettings) -> Connection:
    """Open the connection.

    Raises:
        ChannelError: it cannot be opened.
    """
    host, port = settings.address
    try:
        async with asyncio.timeout(CONNECT_S):
            if settings.transport is TakTransport.UDP:
                infos = await asyncio.get_running_loop().getaddrinfo(host, port, type=socket.SOCK_DGRAM)
                address = cast("tuple[str, int]", infos[0][4][:2])
                return Datagrams(address, settings.interface, receive=settings.receive)
            context = None if settings.transport is TakTransport.TCP else tls_context(settings)
            name = None if context is None else settings.server_name or host
            return Stream(*await asyncio.open_connection(host, port, ssl=context, server_hostname=name))
    except TimeoutError:
        raise ChannelError(f"No answer within {CONNECT_S:.0f} s; check the address and the network.") from None
    except ConfigurationError as error:
        raise ChannelError(str(error), is_refused=True) from error
    except ssl.SSLError as error:
        raise tls_error(error) from error
    except OSError as error:
        raise ChannelError(reason_text(error)) from error


def tls_context(settings: TakSettings) -> ssl.SSLContext:
    """Return the certificates of a connection.

    Raises:
        ConfigurationError: a file of them cannot be used.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    for field in ("ca_file", "certificate_file", "key_file"):
        value = getattr(settings, field)
        if value is not None and not Path(value).is_file():
            remedy = "check the path" if settings.enrol_user is None else "get it by: aos-gcs tak-enrol"
            raise ConfigurationError(f"tak.{field}: {value} does not exist; {remedy}.")
    try:
        context.load_verify_locations(settings.ca_file)
    except (OSError, ssl.SSLError) as error:
        raise ConfigurationError(f"tak.ca_file: {settings.ca_file} is not a PEM file of certificates.") from error
    if settings.certificate_file is not None:
        try:
            # Without a passphrase of ours, the library would ask for one on the terminal.
            context.load_cert_chain(settings.certificate_file, settings.key_file, password="")
        except (OSError, ssl.SSLError) as error:
            raise ConfigurationError(
                "tak.certificate_file, tak.key_file: they are no pair of a PEM certificate and its key without a "
                "passphrase. Convert a .p12 file with: openssl pkcs12 -nodes."
            ) from error
    return context


def reason_text(error: OSError) -> str:
    """Return why a connection cannot be opened."""
    if isinstance(error, ConnectionRefusedError):
        return "The server refuses the connection; check the port, or start the server."
    if isinstance(error, socket.gaierror):
        return "The name of the server is not known; check it, or the network."
    return f"{error.strerror or type(error).__name__}."


def tls_error(error: ssl.SSLError) -> ChannelError:
    """Return what is wrong with the certificates."""
    if isinstance(error, ssl.SSLCertVerificationError):
        if "not yet valid" in error.verify_message:
            text = "The server's certificate is not valid yet: check this machine's clock."
        elif "expired" in error.verify_message:
            text = "The server's certificate has expired, or this machine's clock is wrong."
        elif "match" in error.verify_message or "mismatch" in error.verify_message:
            reason = error.verify_message.rstrip(".")
            text = (
                f"The server's certificate is for another name ({reason}). Set tak.server_name to the name in it, if "
                "that is the server of your team."
            )
        else:
            text = f"The server's certificate is not signed by the authority that we trust ({error.verify_message})."
    elif "ALERT" in (error.reason or ""):
        text = "The server refuses our certificate; check that it knows it."
    else:
        text = f"The server does not speak TLS as expected ({error.reason or error}); check the port."
    return ChannelError(text, is_refused=True)
