"""Damage in the coded pixels of JPEG files, which decoders fill up without an error.

A bad stretch of a memory card reads as zeros, or as ones where it is erased; what was copied over it has markers where
none can be. Both are looked for in the coded data without decoding them. Elsewhere damage is not seen.

Source: JPEG (ITU-T T.81) B.1.1, B.2.4.2 and annex C: the first symbol of a table has a code of zeros.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator

from aos_gcs.errors import InputDataError
from aos_gcs.image_headers import JPEG_START, jpeg_segments

LEAST_RUN_BYTES = 256
"""Bytes of a run that is damage: half a sector of a card. In 1,000 pictures of cameras none has more than six zeros."""
_PREFIX, _END, _SCAN, _TABLES, _LINES = 0xFF, 0xD9, 0xDA, 0xC4, 0xDC
_MARKER = re.compile(rb"\xff([^\x00\xd0-\xd7\xff])")
"""Markers that end coded data: all but the bytes stuffed behind an FF, restarts and fill bytes."""
_SEQUENTIAL = frozenset({0xC0, 0xC1})
_BETWEEN_SCANS = frozenset({_TABLES, _SCAN, _LINES, 0xDB, 0xDD, 0xFE, *range(0xE0, 0xF0)})
_AC_TABLE = 0x10
_END_OF_BLOCK = 0
"""Symbol behind which all coefficients of a block are 0, and among the first ones of blocks that of no change."""


def is_damaged(data: bytes) -> bool:
    """Return whether the coded pixels of a JPEG file are seen to be damaged; False for other files.

    Args:
        data: content of a file whose size could be read, and whose end is there.
    """
    if not data.startswith(JPEG_START):
        return False
    try:
        segments = list(jpeg_segments(data))
        return any(_is_bad(data, segments, *scan) for scan in _scans(data, *segments[-1]))
    except (struct.error, IndexError, ValueError, InputDataError):
        # It ends within a segment, or something else follows one.
        return True


def _scans(data: bytes, marker: int, offset: int) -> Iterator[tuple[int, int, int]]:
    """Yield where the coded data of each scan begin and end, and the marker behind them.

    Raises:
        ValueError: there is something else between two scans than segments.
    """
    while marker == _SCAN:
        begin = offset + 2 + struct.unpack_from(">H", data, offset + 2)[0]
        found = _MARKER.search(data, begin)
        if found is None:
            return
        marker, offset = found[1][0], found.start()
        yield begin, offset, marker
        while marker in _BETWEEN_SCANS and marker != _SCAN:
            offset += 2 + struct.unpack_from(">H", data, offset + 2)[0]
            while data[offset : offset + 2] == b"\xff\xff":  # padding
                offset += 1
            if data[offset] != _PREFIX:
                raise ValueError("no marker where one must be")
            marker = data[offset + 1]
    if marker != _END:
        raise ValueError(f"marker {marker:02X} where none can be")


def _is_bad(data: bytes, segments: list[tuple[int, int]], begin: int, end: int, marker: int) -> bool:
    is_whole = _is_whole(data, segments)
    expected = {_END, _LINES} if is_whole else {_END, *_BETWEEN_SCANS}
    if marker not in expected or data.find(b"\xff" * LEAST_RUN_BYTES, begin, end) >= 0:
        return True
    # In other scans zeros may stand for blocks without a change.
    return is_whole and data.find(bytes(LEAST_RUN_BYTES), begin, end) >= 0 and not _zeros_are_even(data, segments)


def _is_whole(data: bytes, segments: list[tuple[int, int]]) -> bool:
    """Return whether one scan holds the whole picture, as those of cameras do."""
    components = data[segments[-1][1] + 4]
    return any(kind in _SEQUENTIAL and data[offset + 9] == components for kind, offset in segments)


def _zeros_are_even(data: bytes, segments: list[tuple[int, int]]) -> bool:
    """Return whether zeros stand for blocks of one grey level, which pictures may have any number of."""
    first = {}
    for kind, at in segments:
        if kind == _TABLES:
            offset, end = at + 4, at + 2 + struct.unpack_from(">H", data, at + 2)[0]
            while offset < end:
                first[data[offset]] = data[offset + 17]
                offset += 17 + sum(data[offset + 1 : offset + 17])
    scan = segments[-1][1]
    chosen = [data[scan + 6 + 2 * number] for number in range(data[scan + 4])]
    symbols = [first.get(table, -1) for both in chosen for table in (both >> 4, _AC_TABLE | both & 0x0F)]
    return set(symbols) == {_END_OF_BLOCK}
