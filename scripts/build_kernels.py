"""Compile the kernels of imaging where they are missing or not of their present sources.

The Makefile and the installation's build hook both run this file; it needs nothing but Python, and a C compiler
(``cc``, or what the environment variable ``CC`` names). Without one it says so and leaves everything as it is: imaging
then works without the kernels, in more time.
"""

from __future__ import annotations

import ctypes
import os
import platform
import shlex
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "aos_gcs" / "imaging" / "native"
FLAGS = ["-std=gnu11", "-O3", "-fPIC", "-shared", "-Wall", "-Wno-psabi"]
# No fused products: all processors give the same digits.
FLAGS += ["-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]


def main() -> None:
    """Do what is needed, which is mostly nothing."""
    checksum = sources_checksum()
    libraries = {"imaging-kernels.so": []}
    if platform.machine() in {"x86_64", "AMD64"}:
        libraries["imaging-kernels-avx2.so"] = ["-mavx2"]
    missing = {name: flags for name, flags in libraries.items() if built_from(PACKAGE / name) != checksum}
    compiler = shlex.split(os.environ.get("CC", "cc"))
    if missing and (not compiler or shutil.which(compiler[0]) is None):
        sys.stderr.write("There is no C compiler: imaging works without its kernels, in more time.\n")
        return
    for name, flags in missing.items():
        if not compile_library(compiler, PACKAGE / name, [*FLAGS, *flags, f"-DAOS_SOURCES={checksum}u"]):
            return


def compile_library(compiler: list[str], path: Path, flags: list[str]) -> bool:
    """Compile all sources to a library, and tell whether that has worked."""
    sources = sorted(str(source) for source in (PACKAGE / "src").glob("*.c"))
    # Beside its place and moved there: a process that has loaded the old library keeps it.
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    command = [*compiler, *flags, "-o", str(unfinished), *sources, "-lm"]
    result = subprocess.run(command, check=False, capture_output=True, text=True)  # noqa: S603 (our own sources)
    if result.returncode:
        unfinished.unlink(missing_ok=True)
        sys.stderr.write(
            f"The kernels of imaging cannot be compiled; it works without them, in more time.\n{result.stderr}"
        )
        return False
    unfinished.replace(path)
    return True


def sources_checksum() -> int:
    """Return the checksum that aos_gcs.imaging.native.library computes."""
    checksum = 0
    for path in sorted((PACKAGE / "src").iterdir()):
        if path.suffix in {".c", ".h"}:
            checksum = zlib.crc32(path.read_bytes(), checksum)
    return checksum


def built_from(path: Path) -> int | None:
    """Return the checksum of the sources that a library was compiled from; None where there is none."""
    try:
        library = ctypes.CDLL(str(path))
        library.aos_sources.restype = ctypes.c_uint
        return int(library.aos_sources())
    except (OSError, AttributeError):
        return None


if __name__ == "__main__":
    main()
