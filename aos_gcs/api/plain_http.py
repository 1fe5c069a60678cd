"""Answers to requests without encryption at a port that is encrypted."""

from __future__ import annotations

import re
from typing import Final

TLS_HANDSHAKE: Final = 0x16
"""First byte of an encrypted connection; no request over plain HTTP begins with it."""
_REQUEST: Final = re.compile(rb"(?:GET|HEAD) (/[\x21-\x7e]*) HTTP/1\.[01]\r\n")
_HOST: Final = re.compile(
    rb"\r\nhost:[ \t]*([A-Za-z0-9.\-]+(?::\d{1,5})?|\[[0-9A-Fa-f:.]+\](?::\d{1,5})?)[ \t]*\r\n", re.IGNORECASE
)
_REFUSED: Final = b"This address is encrypted: use https://.\n"


def plain_answer(head: bytes) -> bytes:
    """Return where a page is to be read instead; anything else is refused, since it may have been read by others."""
    request, host = _REQUEST.match(head), _HOST.search(head)
    if request is None or host is None:
        return _response(b"403 Forbidden", b"", _REFUSED)
    return _response(b"308 Permanent Redirect", b"Location: https://%b%b\r\n" % (host[1], request[1]), _REFUSED)


def _response(status: bytes, headers: bytes, body: bytes) -> bytes:
    return (
        b"HTTP/1.1 %b\r\n%bContent-Type: text/plain\r\nCache-Control: no-store\r\nContent-Length: %d\r\n"
        b"Connection: close\r\n\r\n%b" % (status, headers, len(body), body)
    )
