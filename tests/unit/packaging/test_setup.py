"""What `make` does before it gets to work."""

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PIN = re.compile(r"(?P<name>[A-Za-z0-9._-]+)==[A-Za-z0-9.+!]+")

TARGETS = ("demo", "check", "test", "test-slow", "test-sitl", "soak-test", "bench", "lint", "wheel", "clean")

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


def run(*command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    path = "/usr/local/bin:/usr/bin:/bin"
    return subprocess.run(  # noqa: S603
        command, cwd=ROOT, env={"PATH": path} | environment, capture_output=True, text=True, check=False
    )


def normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def pins() -> list[str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    return [line for line in lines if not line.startswith("#")]


def test_constraints_are_exact_and_name_no_registry() -> None:
    assert pins()
    assert [line for line in pins() if not PIN.fullmatch(line)] == []


def test_every_dependency_of_every_extra_is_pinned() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    requirements = [
        *project["dependencies"],
        *(item for extra in project["optional-dependencies"].values() for item in extra),
    ]
    names = {normalised(re.split(r"[\[<>=~! ;]", requirement)[0]) for requirement in requirements} - {project["name"]}
    assert names - {normalised(line.split("==")[0]) for line in pins()} == set()


def test_help_is_the_default_and_describes_every_target() -> None:
    result = run("make")
    assert result.returncode == 0
    assert [target for target in TARGETS if not re.search(rf"^make {target} +\w", result.stdout, re.MULTILINE)] == []


@pytest.fixture
def python(tmp_path: Path) -> Path:
    """A program in the place of a Python that is too old, or a version manager's shim without a Python behind it."""
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\nexit 1\n")
    program.chmod(0o755)
    return program


def test_an_old_python_is_one_sentence(python: Path) -> None:
    result = run("sh", "scripts/find_python.sh", PYTHON=str(python))
    assert result.returncode == 1
    (line,) = result.stderr.splitlines()
    assert line.startswith("aos-gcs needs Python 3.11 or newer")


def test_a_python_without_venv_is_one_sentence(python: Path, tmp_path: Path) -> None:
    python.write_text('#!/bin/sh\ncase "$2" in *ensurepip*) exit 1 ;; *print*) echo 3.11 ;; esac\n')
    result = run("sh", "scripts/make_venv.sh", str(tmp_path / "venv"), PYTHON=str(python))
    assert result.returncode == 1
    (line,) = result.stderr.splitlines()
    assert "sudo apt-get install python3.11-venv" in line
    assert not (tmp_path / "venv").exists()
