"""The compiled library: found beside this module, used where it belongs to these very sources.

``scripts/build_kernels.py`` compiles it, at the installation where there is a C compiler. Without it everything works
as well, in more passes over the same numbers.
"""

from __future__ import annotations

import ctypes
import os
import zlib
from functools import cache
from pathlib import Path

SOURCES = Path(__file__).parent / "src"
FILE = "imaging-kernels.so"
"""Library for all processors."""
AVX2_FILE = "imaging-kernels-avx2.so"
"""Library for x86 processors with AVX2, which gives the same digits."""
SWITCH = "AOS_GCS_KERNELS"
"""Environment variable that makes imaging do without the library when it is ``off``."""

_LONG, _INT, _POINTER = ctypes.c_long, ctypes.c_int, ctypes.c_void_p
_ON_PLANE = [_POINTER, _LONG, _INT, _INT, _LONG, _LONG, _LONG, _POINTER, _POINTER, _POINTER]
_ARGUMENTS = {
    "aos_add_warped": _ON_PLANE,
    "aos_mean_of_warped": _ON_PLANE,
    "aos_add_through_lenses": _ON_PLANE,
    "aos_add_points": [_POINTER, _POINTER, _LONG, _POINTER, _LONG, _INT, _INT, _LONG, _LONG] + 3 * [_POINTER],
    "aos_covered_spans": [_POINTER, _LONG, _LONG, _LONG, _POINTER],
    "aos_add_spans": [_POINTER, _LONG, _LONG, _LONG, _POINTER],
    "aos_divide": [_POINTER, _POINTER, _LONG, _INT, _POINTER],
    "aos_moments": [_POINTER, _INT, _LONG, _INT, _POINTER, _POINTER, _POINTER, _POINTER],
    "aos_distances": [_POINTER, _INT, _LONG, _INT, _POINTER, _POINTER, _POINTER],
    "aos_local_scores": [
        _POINTER,
        _POINTER,
        _LONG,
        _LONG,
        _INT,
        _LONG,
        _LONG,
        ctypes.c_float,
        _LONG,
        _POINTER,
    ],
}


_WITH_RESULT = frozenset(
    {"aos_add_warped", "aos_add_through_lenses", "aos_add_points", "aos_mean_of_warped", "aos_local_scores"}
)
"""Functions that return an integer; the others return nothing."""


@cache
def loaded() -> ctypes.CDLL | None:
    """Return the library; None where there is none for this processor, or it is not of these sources."""
    if os.environ.get(SWITCH) == "off":
        return None
    library = _open(FILE)
    if library is not None and library.aos_has_avx2():
        library = _open(AVX2_FILE) or library
    return library


def sources_checksum() -> int:
    """Return a checksum of the sources of the library."""
    checksum = 0
    for path in sorted(SOURCES.iterdir()):
        if path.suffix in {".c", ".h"}:
            checksum = zlib.crc32(path.read_bytes(), checksum)
    return checksum


def _open(file: str) -> ctypes.CDLL | None:
    try:
        library = ctypes.CDLL(str(Path(__file__).parent / file))
        library.aos_sources.restype = ctypes.c_uint
        # A library of other sources may take other arguments.
        if library.aos_sources() != sources_checksum():
            return None
        for name, arguments in _ARGUMENTS.items():
            # By attribute: an index makes a new function each time.
            function = getattr(library, name)
            function.argtypes, function.restype = arguments, _INT if name in _WITH_RESULT else None
    except (OSError, AttributeError):
        return None
    return library
