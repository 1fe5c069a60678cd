"""Requests of CalTopo: its position report, and the signed ones of its Team API.

The forms are those of the service's own page "Supported API for Teams", and of the report that trackers use. A
signature is the HMAC-SHA256, by the decoded secret, of method and path, the time at which it expires, and the JSON,
each on a line.
"""

from __future__ import annotations

import base64
import binascii
import hmac
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final
from urllib.parse import quote, urlencode

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.sharing.http import Request

POSITION_TIMEOUT_S: Final = 3.0
"""Longest time for a report: the service takes a position for one of the time at which it arrives."""
_EXPIRES_S: Final = 120.0
_FORM: Final = {"Content-Type": "application/x-www-form-urlencoded"}


@dataclass(frozen=True, slots=True)
class Credential:
    """Credential of a service account."""

    credential_id: str
    secret: bytes

    @classmethod
    def from_text(cls, credential_id: str, secret: str) -> Credential:
        """Return the credential of a secret as the service shows it.

        Raises:
            ConfigurationError: the secret is no base64.
        """
        try:
            return cls(credential_id, base64.b64decode(secret, validate=True))
        except binascii.Error:
            text = "caltopo.credential_secret_file: this is no credential secret, a long text in base64."
            raise ConfigurationError(text) from None

    def signature(self, method: str, path: str, expires_ms: int, payload: str) -> str:
        """Return the signature of a request."""
        message = f"{method} {path}\n{expires_ms}\n{payload}"
        return base64.b64encode(hmac.digest(self.secret, message.encode(), "sha256")).decode()


def device_name(name: str, vehicle_id: int) -> str:
    """Return the id of a vehicle in its reports."""
    return f"{name}{vehicle_id:02d}"


def position_report(url: str, connect_key: str, device: str, position: GeodeticPosition) -> Request:
    """Return the report of one position, which needs no signature."""
    place = {"lat": f"{position.latitude_deg:.7f}", "lng": f"{position.longitude_deg:.7f}"}
    query = urlencode({"id": device} | place)
    address = f"{url}/api/v1/position/report/{quote(connect_key, safe='')}?{query}"
    return Request("GET", address, timeout_s=POSITION_TIMEOUT_S)


def signed(
    url: str,
    credential: Credential,
    method: str,
    path: str,
    *,
    utc_s: float,
    payload: Mapping[str, Any] | None = None,
) -> Request:
    """Return a signed request of the Team API.

    Args:
        url: scheme, host and port of the service.
        credential: credential of the service account.
        method: ``GET``, ``POST`` or ``DELETE``.
        path: path of the endpoint.
        utc_s: present time.
        payload: object to write; None where none is.
    """
    text = "" if payload is None else json.dumps(payload, ensure_ascii=False, allow_nan=False)
    expires_ms = int((utc_s + _EXPIRES_S) * 1000.0)
    fields = {
        "id": credential.credential_id,
        "expires": str(expires_ms),
        "signature": credential.signature(method, path, expires_ms, text),
    }
    if payload is None:
        return Request(method, f"{url}{path}?{urlencode(fields)}")
    return Request(method, f"{url}{path}", urlencode(fields | {"json": text}).encode(), _FORM)
