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
from dataclasses import dataclass
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
    started = [
        start_compiler(compiler, PACKAGE / name, [*FLAGS, *flags, f"-DAOS_SOURCES={checksum}u"])
        for name, flags in missing.items()
    ]
    errors = [finish(compilation) for compilation in started]
    if failed := next(filter(None, errors), None):
        sys.stderr.write(f"The kernels of imaging cannot be compiled; it works without them, in more time.\n{failed}")


@dataclass(frozen=True)
class Compilation:
    """A library that is being compiled."""

    compiler: subprocess.Popen[str]
    unfinished: Path
    path: Path


def start_compiler(compiler: list[str], path: Path, flags: list[str]) -> Compilation:
    """Begin to compile all sources to a library: the libraries are compiled side by side, one per core."""
    sources = sorted(str(source) for source in (PACKAGE / "src").glob("*.c"))
    # Beside its place and moved there: a process that has loaded the old library keeps it.
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    command = [*compiler, *flags, "-o", str(unfinished), *sources, "-lm"]
    process = subprocess.Popen(  # noqa: S603 (our own sources)
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    return Compilation(process, unfinished, path)


def finish(compilation: Compilation) -> str:
    """Wait for a library and put it in its place; return what the compiler says if it fails, else nothing."""
    _, told = compilation.compiler.communicate()
    if compilation.compiler.returncode:
        compilation.unfinished.unlink(missing_ok=True)
        return told or f"The compiler has ended with exit status {compilation.compiler.returncode}."
    compilation.unfinished.replace(compilation.path)
    return ""


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
