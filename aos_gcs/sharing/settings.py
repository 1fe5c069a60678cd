"""Settings of live sharing."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any
from urllib.parse import urlsplit

from aos_gcs.errors import ConfigurationError

_NAME = re.compile(r"[\w .-]{1,32}")


class TakTransport(StrEnum):
    """Transport of Cursor on Target."""

    UDP = "udp"
    TCP = "tcp"
    TLS = "tls"


@dataclass(frozen=True, slots=True)
class TakSettings:
    """The connection to TAK."""

    url: str
    """``udp://239.2.3.1:6969`` (multicast, or one receiver), ``tcp://host:8087`` or ``tls://host:8089``."""
    name: str = "aos-gcs"
    """Name of this station, which begins the call signs; another one for each station."""
    ca_file: str | None = None
    """Certificates (PEM) that the server's is signed by; needed for ``tls``."""
    certificate_file: str | None = None
    """Our certificate (PEM), where the server asks for one."""
    key_file: str | None = None
    """Private key of our certificate (PEM, without a passphrase)."""
    server_name: str | None = None
    """Name in the server's certificate; by default the host of ``url``."""
    enrol_user: str | None = None
    """Account by which ``aos-gcs tak-enrol`` has the server sign our certificate."""
    enrol_port: int = 8446
    """Port of the server for that."""
    enrol_password_file: str | None = None
    """File of its password; by default the variable AOS_GCS_TAK_PASSWORD."""
    interface: str | None = None
    """Address of the network interface that multicast leaves and comes by; by default the system's choice."""
    receive: bool = False
    """Whether marks and drawings of others become proposals for the plan; for multicast, ``tcp`` and ``tls``."""
    geoid: str | None = None
    """PROJ's grid of the geoid EGM96; by default looked for in PROJ's folders."""

    def __post_init__(self) -> None:
        transport = self.transport  # Refused here, as are host and port.
        if not self.address[0]:
            raise ConfigurationError("url has no host; write it like udp://239.2.3.1:6969.")
        if not _NAME.fullmatch(self.name):
            raise ConfigurationError("name must have 1 to 32 letters, digits, blanks, dots or dashes.")
        files = {"ca_file": self.ca_file, "certificate_file": self.certificate_file, "key_file": self.key_file}
        if transport is not TakTransport.TLS:
            others = {"server_name": self.server_name, "enrol_user": self.enrol_user}
            for field, value in (files | others).items():
                if value is not None:
                    raise ConfigurationError(f"{field} is for tls:// only; take it out, or change url.")
        elif self.ca_file is None:
            raise ConfigurationError("tls:// needs ca_file: the certificate that the server's is signed by.")
        elif (self.certificate_file is None) != (self.key_file is None):
            raise ConfigurationError("give certificate_file and key_file together.")
        if self.enrol_user is not None and not re.fullmatch(r"[^\s:](?:[^:\n]{0,62}[^\s:])?", self.enrol_user):
            raise ConfigurationError("enrol_user must be the name of an account: 1 to 64 letters, without a colon.")
        if not 1 <= self.enrol_port <= 65535:
            raise ConfigurationError("enrol_port must be a port from 1 to 65535, such as 8446.")
        if self.interface is not None and transport is not TakTransport.UDP:
            raise ConfigurationError("interface is for udp:// only.")
        if self.receive and transport is TakTransport.UDP and not self.is_multicast:
            raise ConfigurationError("receive needs an IPv4 multicast group such as udp://239.2.3.1:6969, or a server.")

    @property
    def transport(self) -> TakTransport:
        """Transport that the URL names."""
        scheme = urlsplit(self.url).scheme
        if scheme not in set(TakTransport):
            raise ConfigurationError(f"url must begin with udp://, tcp:// or tls://, not {scheme or 'nothing'}.")
        return TakTransport(scheme)

    @property
    def is_multicast(self) -> bool:
        """Whether the host is an IPv4 multicast group."""
        try:
            return ipaddress.IPv4Address(self.address[0]).is_multicast
        except ValueError:
            return False

    @property
    def address(self) -> tuple[str, int]:
        """Host and port."""
        parts = urlsplit(self.url)
        try:
            port = parts.port
        except ValueError:
            port = None
        if not port:
            raise ConfigurationError("url needs a port from 1 to 65535, such as :8089.")
        return parts.hostname or "", port


@dataclass(frozen=True, slots=True)
class WebhookSettings:
    """Receiver of messages about findings and alerts."""

    url: str
    """``https://host/path``; ``http://`` for receivers in the same network."""
    secret_file: str | None = None
    """File of the secret by which messages are signed; by default the variable AOS_GCS_WEBHOOK_SECRET."""
    ca_file: str | None = None
    """Certificates (PEM) that the receiver's is signed by; by default those of the system."""

    def __post_init__(self) -> None:
        _check_http(self.url)


@dataclass(frozen=True, slots=True)
class CaltopoSettings:
    """CalTopo, by its service or by a server of the same interface."""

    positions: bool = False
    """Whether to report the positions of the vehicles, as ``name`` and id, by the connect key."""
    connect_key_file: str | None = None
    """File of the connect key; by default the variable AOS_GCS_CALTOPO_CONNECT_KEY."""
    map: str | None = None
    """Id of the map that gets findings, area, legs and tracks; None: no map does."""
    credential_id: str | None = None
    """Id of the service account's credential, for the map."""
    credential_secret_file: str | None = None
    """File of its secret; by default the variable AOS_GCS_CALTOPO_SECRET."""
    name: str = "AOS"
    """Letters and digits that begin the names of the vehicles; others for each station."""
    url: str = "https://caltopo.com"

    def __post_init__(self) -> None:
        _check_http(self.url)
        if not self.positions and self.map is None:
            raise ConfigurationError("set positions = true, or map, or both; else leave the section out.")
        if not re.fullmatch(r"[A-Za-z0-9]{1,12}", self.name):
            raise ConfigurationError("name must have 1 to 12 letters and digits.")
        if self.map is not None and not re.fullmatch(r"[A-Za-z0-9]{1,32}", self.map):
            raise ConfigurationError("map must be the id in the map's address, such as ABC12.")
        if self.map is not None and not self.credential_id:
            raise ConfigurationError("map needs credential_id, that of a service account of the team.")


def without_secrets(url: str) -> str:
    """Return scheme, host and port of a URL: its path, its query and its user may be secret."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}"


def _check_http(url: str) -> None:
    parts = urlsplit(url)
    try:
        is_usable = parts.scheme in {"http", "https"} and bool(parts.hostname) and parts.port != 0
    except ValueError:
        is_usable = False
    if not is_usable:
        raise ConfigurationError("url must be like https://example.org/hook.")


@dataclass(frozen=True, slots=True)
class SharingSettings:
    """All Systems that data is shared with; None where it is not."""

    tak: TakSettings | None = None
    webhook: WebhookSettings | None = None
    caltopo: CaltopoSettings | None = None

    @classmethod
    def from_tables(cls, tables: Mapping[str, Mapping[str, Any] | None]) -> SharingSettings:
        """Return the settings of checked tables, one per system."""
        tak, webhook, caltopo = (tables.get(name) for name in ("tak", "webhook", "caltopo"))
        return cls(
            tak=None if tak is None else TakSettings(**tak),
            webhook=None if webhook is None else WebhookSettings(**webhook),
            caltopo=None if caltopo is None else CaltopoSettings(**caltopo),
        )

    @property
    def has_proposals(self) -> bool:
        """Whether what others mark and draw is received."""
        return self.tak is not None and self.tak.receive

    @property
    def any(self) -> bool:
        """Whether there is any."""
        return self != SharingSettings()
