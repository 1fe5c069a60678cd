"""Sizes of the pictures in an image file, read from its headers alone, before anything is decoded.

A few kilobytes can claim, and compress, billions of pixels. Only PNG, JPEG and TIFF are known; what is none of them is
refused, so that the decoders of other formats are never reached. Where a file gives its size in two ways, or in a way
that is not read here, a decoder may take another size than this module: such files are refused.

Sources: PNG (W3C, 3rd edition) 11.2.1; JPEG (ITU-T T.81) B.1.1 and B.2.2; TIFF 6.0 section 2, BigTIFF is not read.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from mmap import mmap

from aos_gcs.errors import InputDataError

FileContent = bytes | mmap
"""Content of a file, in memory or where it lies."""

PNG_START, JPEG_START = b"\x89PNG\r\n\x1a\n", b"\xff\xd8"
_PNG_END, _JPEG_END = b"IEND\xaeB`\x82", b"\xff\xd9"
_TAIL_BYTES = 64
"""Bytes at the end of a file within which its end marker is looked for first."""
TIFF_STARTS = (b"II", b"MM")
_TIFF_ORDERS = {b"II*\0": "<", b"MM\0*": ">"}
_MAX_TIFF_PAGES = 8
_TIFF_WIDTH, _TIFF_HEIGHT, _TIFF_TILE_WIDTH, _TIFF_TILE_HEIGHT = 256, 257, 322, 323
_TIFF_ORIENTATION, _TIFF_SHORT = 274, 3
_TIFF_INTEGERS = {1: "B", 3: "H", 4: "I"}
"""Struct's code by type of a field: byte, short, long."""
_NO_JPEG_FRAME = frozenset({0xC4, 0xC8, 0xCC})
"""Markers among C0 to CF that start no frame: tables and extensions."""
_JPEG_SCAN = 0xDA
_JPEG_STANDALONE = frozenset({0x01, *range(0xD0, 0xD8)})


class TornImageError(InputDataError):
    """An image file that ends within its headers."""


def picture_sizes(data: FileContent) -> list[tuple[int, int]]:
    """Return width and height of each page of a file.

    Raises:
        TornImageError: it ends within its headers.
        InputDataError: it is neither PNG, JPEG nor TIFF, or its headers make no sense.
    """
    try:
        if _starts(data, PNG_START):
            return [_png_size(data)]
        if _starts(data, JPEG_START):
            return [_jpeg_size(data)]
        if data[:4] in _TIFF_ORDERS:
            return _tiff_sizes(data, _TIFF_ORDERS[data[:4]])
    except struct.error as error:
        raise TornImageError(f"the image file of {len(data)} bytes is incomplete") from error
    if not data:
        raise TornImageError("the image file of 0 bytes is incomplete")
    raise InputDataError(f"the image file of {len(data)} bytes is neither PNG, JPEG nor TIFF")


def is_cut_off(data: FileContent) -> bool:
    """Return whether the end of a PNG or JPEG file is missing; decoders fill up such files without a word.

    What programs and cameras append behind the end of a picture does not matter. TIFF files have no end: their decoders
    notice what is missing.
    """
    tail = data[-_TAIL_BYTES:]
    if _starts(data, PNG_START):
        return _PNG_END not in tail and data.find(_PNG_END, len(PNG_START)) < 0
    # Nothing in the picture itself looks like the end (T.81, B.1.1.5); a preview before it has an end of its own.
    return _starts(data, JPEG_START) and _JPEG_END not in tail and data.find(_JPEG_END, _jpeg_scan(data)) < 0


def as_stored(data: bytes) -> bytes:
    """Return an image file without an Orientation tag by which decoders turn pixels: those of TIFFs do in OpenCV 5.

    Decoders of PNG and JPEG files leave the pixels as they are stored when asked to.

    Args:
        data: content of a file whose sizes could be read.
    """
    order = _TIFF_ORDERS.get(data[:4])
    if order is None:
        return data
    offsets = [offset for fields in _tiff_pages(data, order) for offset in fields]
    tagged = [offset for offset in offsets if _tiff_field(data, order, offset)[0] == _TIFF_ORIENTATION]
    if not tagged:
        return data
    changed = bytearray(data)
    for offset in tagged:
        struct.pack_into(f"{order}HHIHH", changed, offset, _TIFF_ORIENTATION, _TIFF_SHORT, 1, 1, 0)
    return bytes(changed)


def _starts(data: FileContent, start: bytes) -> bool:
    return data[: len(start)] == start


def _png_size(data: FileContent) -> tuple[int, int]:
    width, height = struct.unpack_from(">II", data, 16)
    return width, height


def _jpeg_size(data: FileContent) -> tuple[int, int]:
    """Walk from marker to marker to the first frame header."""
    for marker, offset in jpeg_segments(data):
        if 0xC0 <= marker <= 0xCF and marker not in _NO_JPEG_FRAME:
            height, width = struct.unpack_from(">HH", data, offset + 5)
            return width, height
    raise InputDataError("the JPEG file has no frame header")


def _jpeg_scan(data: FileContent) -> int:
    """Return where the first scan begins; the end of the file if there is none."""
    try:
        return next((offset for marker, offset in jpeg_segments(data) if marker == _JPEG_SCAN), len(data))
    except (struct.error, InputDataError):
        return len(data)


def jpeg_segments(data: FileContent) -> Iterator[tuple[int, int]]:
    """Yield the marker and the offset of each segment of a JPEG file, up to the first scan.

    Raises:
        InputDataError: there is none where one must be.
        struct.error: the file ends before.
    """
    offset, marker = 2, 0
    while marker != _JPEG_SCAN:
        prefix, marker = struct.unpack_from(">BB", data, offset)
        if prefix != 0xFF:
            raise InputDataError("the JPEG file has no frame header where one must be")
        if marker == 0xFF:  # padding
            offset += 1
        elif marker in _JPEG_STANDALONE:
            offset += 2
        else:
            yield marker, offset
            offset += 2 + max(2, struct.unpack_from(">H", data, offset + 2)[0])


def _tiff_sizes(data: FileContent, order: str) -> list[tuple[int, int]]:
    sizes: list[tuple[int, int]] = []
    for offsets in _tiff_pages(data, order):
        fields = [_tiff_field(data, order, offset) for offset in offsets]
        width, height = _tiff_edge(fields, _TIFF_WIDTH), _tiff_edge(fields, _TIFF_HEIGHT)
        if not width or not height:
            raise InputDataError(f"page {len(sizes) + 1} of the TIFF file has no size")
        # Decoders keep a whole tile in memory, however small the page.
        tile_width, tile_height = _tiff_edge(fields, _TIFF_TILE_WIDTH), _tiff_edge(fields, _TIFF_TILE_HEIGHT)
        sizes.append((max(width, tile_width), max(height, tile_height)))
    return sizes


def _tiff_pages(data: FileContent, order: str) -> Iterator[list[int]]:
    """Yield the offsets of the fields of each page."""
    pages = 0
    offset = struct.unpack_from(f"{order}I", data, 4)[0]
    while offset:
        pages += 1
        if pages > _MAX_TIFF_PAGES:
            raise InputDataError(f"the TIFF file has more than {_MAX_TIFF_PAGES} pages")
        count = struct.unpack_from(f"{order}H", data, offset)[0]
        yield [offset + 2 + 12 * index for index in range(count)]
        offset = struct.unpack_from(f"{order}I", data, offset + 2 + 12 * count)[0]


def _tiff_field(data: FileContent, order: str, offset: int) -> tuple[int, int | None]:
    """Return tag and value of a field that holds one integer; None for others, whose values lie elsewhere."""
    tag, kind, count = struct.unpack_from(f"{order}HHI", data, offset)
    code = _TIFF_INTEGERS.get(kind)
    if code is None or count != 1:
        return tag, None
    return tag, struct.unpack_from(f"{order}{code}", data, offset + 8)[0]


def _tiff_edge(fields: list[tuple[int, int | None]], wanted: int) -> int:
    """Return the value of a field that gives an edge; 0 without one."""
    values = [value for tag, value in fields if tag == wanted]
    if len(values) > 1 or None in values:
        raise InputDataError(f"the TIFF file gives a size twice, or not as one integer (tag {wanted})")
    return values[0] or 0 if values else 0
