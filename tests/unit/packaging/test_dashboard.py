"""The script that builds the dashboard for make and for the wheel, with a stand-in for Node."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.realtime

ROOT = Path(__file__).resolve().parents[3]

NPM = """#!/bin/sh
echo "npm $*" >> "$CALLS"
case "$*" in
    ci) mkdir -p node_modules && echo {} > node_modules/.package-lock.json ;;
    "run build") mkdir -p ../aos_gcs/api/static && echo built > ../aos_gcs/api/static/index.html ;;
esac
"""


class Clone:
    """A repository with nothing but the dashboard's sources, and programs named node and npm."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.bin = root / "bin"
        self.page = root / "aos_gcs" / "api" / "static" / "index.html"
        self.source = root / "web" / "src" / "main.ts"
        self.lock = root / "web" / "package-lock.json"
        for folder in (self.bin, root / "scripts", self.source.parent):
            folder.mkdir(parents=True)
        shutil.copy(ROOT / "scripts" / "build_dashboard.py", root / "scripts")
        (root / "web" / "package.json").write_text(json.dumps({"engines": {"node": ">=20.19"}}))
        self.lock.write_text("{}")
        self.source.write_text("")
        for path in (root / "web").rglob("*"):
            os.utime(path, (1_000_000, 1_000_000))
        self.put("npm", NPM)
        self.put("node", "#!/bin/sh\necho v20.19.2\n")

    def put(self, name: str, script: str) -> None:
        program = self.bin / name
        program.write_text(script)
        program.chmod(0o755)

    def touch(self, path: Path) -> None:
        newer = max(other.stat().st_mtime for other in self.root.rglob("*")) + 10
        os.utime(path, (newer, newer))

    def build(self, *options: str) -> tuple[str, list[str]]:
        """Run the script; return what it said on standard error and the calls of npm."""
        calls = self.root / "calls"
        calls.write_text("")
        result = subprocess.run(  # noqa: S603
            [sys.executable, self.root / "scripts" / "build_dashboard.py", *options],
            env={
                "PATH": f"{self.bin}:/bin:/usr/bin" if (self.bin / "npm").exists() else str(self.bin),
                "CALLS": str(calls),
            },
            capture_output=True,
            text=True,
            check=False,
        )
        assert bool(result.stderr) == bool(result.returncode)
        return result.stderr, calls.read_text().splitlines()


@pytest.fixture
def clone(tmp_path: Path) -> Clone:
    return Clone(tmp_path)


def test_a_fresh_clone_installs_and_builds_once(clone: Clone) -> None:
    assert clone.build() == ("", ["npm ci", "npm run build"])
    assert clone.build() == ("", [])


def test_a_changed_source_is_built_without_installing(clone: Clone) -> None:
    clone.build()
    clone.touch(clone.source)
    assert clone.build() == ("", ["npm run build"])


def test_changed_packages_are_installed_and_built(clone: Clone) -> None:
    clone.build()
    clone.touch(clone.lock)
    assert clone.build() == ("", ["npm ci", "npm run build"])


def test_installed_packages_do_not_count_as_sources(clone: Clone) -> None:
    clone.build()
    clone.touch(clone.root / "web" / "node_modules" / ".package-lock.json")
    assert clone.build() == ("", [])


def test_a_built_page_needs_no_packages_but_the_checks_do(clone: Clone) -> None:
    clone.build()
    shutil.rmtree(clone.root / "web" / "node_modules")
    assert clone.build() == ("", [])
    assert clone.build("--with-tools") == ("", ["npm ci"])


def test_an_archive_without_sources_uses_its_page(clone: Clone) -> None:
    clone.build()
    shutil.rmtree(clone.root / "web")
    assert clone.build() == ("", [])
    clone.page.unlink()
    message, _ = clone.build()
    assert message == "The dashboard cannot be built: its sources (web/) are missing.\n"


@pytest.mark.parametrize("version", ["v18.20.4", "v20.18.0"])
def test_an_old_node_is_one_sentence(clone: Clone, version: str) -> None:
    clone.put("node", f"#!/bin/sh\necho {version}\n")
    message, calls = clone.build()
    assert message == "The dashboard needs Node 20.19 or newer with npm to be built: install it and try again.\n"
    assert calls == []


def test_a_missing_node_is_one_sentence(clone: Clone) -> None:
    for name in ("node", "npm"):
        (clone.bin / name).unlink()
    message, _ = clone.build()
    assert message == "The dashboard needs Node 20.19 or newer with npm to be built: install it and try again.\n"


def test_a_build_that_fails_names_the_command(clone: Clone) -> None:
    clone.put("npm", "#!/bin/sh\nexit 1\n")
    assert clone.build() == ("The dashboard cannot be built: `npm ci` in web/ has failed.\n", [])
