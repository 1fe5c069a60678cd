"""Build the dashboard into the Python package when it is missing or older than its sources.

The Makefile and the wheel's build hook both run this file; it needs nothing but Python and Node.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WEB = ROOT / "web"
PAGE = ROOT / "aos_gcs" / "api" / "static" / "index.html"
INSTALLED = WEB / "node_modules" / ".package-lock.json"
"""Written by npm at the end of every installation."""


def main() -> None:
    """Do what is needed, which is mostly nothing."""
    if not WEB.is_dir():
        sys.exit(None if PAGE.exists() else "The dashboard cannot be built: its sources (web/) are missing.")
    must_build = is_older(PAGE, sources())
    if is_older(INSTALLED, [WEB / "package-lock.json"]) and (must_build or "--with-tools" in sys.argv):
        npm("ci")
    if must_build:
        npm("run", "build")


def sources() -> Iterator[Path]:
    """All files that may have a part in the page."""
    for folder, subfolders, names in os.walk(WEB):
        subfolders[:] = [name for name in subfolders if name != "node_modules"]
        yield from (Path(folder) / name for name in names)


def is_older(product: Path, ingredients: Iterable[Path]) -> bool:
    """Whether a product is missing or older than one of its ingredients."""
    if not product.exists():
        return True
    made_ns = product.stat().st_mtime_ns
    return any(path.stat().st_mtime_ns > made_ns for path in ingredients)


def npm(*arguments: str) -> None:
    """Run npm in ``web/``, or end with one sentence: what is missing, or the command that failed (npm has said why)."""
    program = shutil.which("npm")
    if program is None or version_of_node() < wanted_node():
        text = ".".join(str(part) for part in wanted_node())
        sys.exit(f"The dashboard needs Node {text} or newer with npm to be built: install it and try again.")
    if subprocess.run([program, *arguments], cwd=WEB, check=False).returncode:  # noqa: S603 (our own arguments)
        sys.exit(f"The dashboard cannot be built: `npm {' '.join(arguments)}` in web/ has failed.")


def version_of_node() -> tuple[int, ...]:
    """Version of the Node on the PATH; empty when there is none."""
    program = shutil.which("node")
    if program is None:
        return ()
    answer = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)  # noqa: S603
    return numbers(answer.stdout)


def wanted_node() -> tuple[int, ...]:
    """The oldest Node that ``package.json`` allows."""
    return numbers(json.loads((WEB / "package.json").read_text())["engines"]["node"])


def numbers(version: str) -> tuple[int, ...]:
    """Return the numbers in a version's text."""
    return tuple(int(part) for part in re.findall(r"\d+", version))


if __name__ == "__main__":
    main()
