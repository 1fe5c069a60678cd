"""Texts that name links, and the addresses of the senders heard on them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qsl

from aos_gcs.errors import ConfigurationError

_NETWORK = re.compile(
    r"(?P<kind>udpin|udpout|tcpout|tcpin|tcp)://(?P<host>\[[0-9A-Fa-f:.]+\]|[^\s:/?\[\]]+):(?P<number>\d{1,5})"
)
_SERIAL = re.compile(r"(?P<kind>serial)://(?P<host>/[^\s:?]+):(?P<number>\d{1,7})")
_FORMS = "udpin://HOST:PORT, udpout://HOST:PORT, tcpout://HOST:PORT, tcpin://HOST:PORT or serial:///DEVICE:BAUD"
_UNSIGNED_POLICIES = {"refuse": False, "accept": True}


class PeerAddress(NamedTuple):
    """Source of bytes: the number of the link, and the socket address (or the serial device) on it."""

    link: int
    host: str
    port: int
    """Port, or the baud rate of a serial device."""

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"

    @property
    def record(self) -> str:
        """Text that ``parse`` reads back, with the number of the link."""
        return f"{self.link} {self.host} {self.port}"

    @classmethod
    def parse(cls, record: str) -> PeerAddress | None:
        """Return the address that was recorded; None where that is none."""
        parts = record.split(" ")
        if len(parts) != 3 or not (parts[0].isdecimal() and parts[2].isdecimal()):
            return None
        return cls(int(parts[0]), parts[1], int(parts[2]))


@dataclass(frozen=True, slots=True)
class SigningOptions:
    """Signing of the packets of one link."""

    key_file: Path
    accepts_unsigned: bool = False
    """Whether packets without a signature are accepted; wrongly signed ones never are."""


@dataclass(frozen=True, slots=True)
class LinkAddress:
    """A parsed link."""

    kind: str
    """``udpin``, ``udpout``, ``tcpout``, ``tcpin`` or ``serial``."""
    host: str
    """Host, or the path of the serial device."""
    port: int
    """Port, or the baud rate of the serial device."""
    text: str
    """Link as the user wrote it."""
    signing: SigningOptions | None = None


def parse_link(text: str) -> LinkAddress:
    """Return the parts of a link's text; ``tcp://`` is ``tcpout://``.

    Raises:
        ConfigurationError: the text has none of the known forms, or an option of it is unknown.
    """
    where, _, query = text.strip().partition("?")
    signing = _parse_signing(query, text) if query else None
    if match := _SERIAL.fullmatch(where):
        baud = int(match["number"])
        if baud == 0:
            raise ConfigurationError(f"link {text!r}: the baud rate must not be 0; telemetry radios often use 57600")
        return LinkAddress("serial", match["host"], baud, text, signing)
    match = _NETWORK.fullmatch(where)
    if match is None or not 0 < int(match["number"]) < 65536:
        raise ConfigurationError(f"link {text!r} cannot be understood: write {_FORMS}, with a port of 1 to 65535")
    kind = "tcpout" if match["kind"] == "tcp" else match["kind"]
    return LinkAddress(kind, match["host"].strip("[]"), int(match["number"]), text, signing)


def _parse_signing(query: str, text: str) -> SigningOptions:
    options = dict(parse_qsl(query, keep_blank_values=True))
    unknown = sorted(set(options) - {"sign", "unsigned"})
    if unknown:
        raise ConfigurationError(f"link {text!r}: unknown option {unknown[0]!r}; use sign=FILE and unsigned=accept")
    if not options.get("sign"):
        raise ConfigurationError(f"link {text!r}: name the key file, as in ?sign=/etc/aos-gcs/mavlink.key")
    policy = options.get("unsigned", "refuse")
    if policy not in _UNSIGNED_POLICIES:
        raise ConfigurationError(f"link {text!r}: unsigned must be refuse or accept, got {policy!r}")
    return SigningOptions(Path(options["sign"]).expanduser(), _UNSIGNED_POLICIES[policy])
