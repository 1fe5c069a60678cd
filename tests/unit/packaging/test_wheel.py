"""A wheel that is built and installed as a user would do it."""

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
INGREDIENTS = ("aos_gcs", "drivers", "sim", "scripts", "pyproject.toml", "hatch_build.py", "README.md", "LICENSE")

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

LEARN_NOTHING_OPTIONAL = """
import importlib.metadata as metadata, importlib.resources as resources
import aos_gcs.cli, aos_gcs.runtime.service, aos_drivers
assert resources.files("aos_gcs.api").joinpath("static/index.html").is_file()
names = {distribution.name for distribution in metadata.distributions()}
assert not names & {"embreex", "mavsdk", "dask", "rasterio", "av"}, names
"""


def run(*command: object, cwd: Path) -> str:
    result = subprocess.run(  # noqa: S603
        [str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_wheel(tmp_path_factory.mktemp("clone"))


def build_wheel(clone: Path) -> Path:
    """Built from a copy with a page of its own, so that the wheel's content is the only thing under test."""
    for name in INGREDIENTS:
        source, ignored = ROOT / name, shutil.ignore_patterns("static", "__pycache__", "*.so")
        shutil.copytree(source, clone / name, ignore=ignored) if source.is_dir() else shutil.copy(source, clone / name)
    assets = clone / "aos_gcs" / "api" / "static" / "assets"
    assets.mkdir(parents=True)
    (assets / "page.js").write_text("")
    (assets.parent / "index.html").write_text("<!doctype html>")
    (clone / ".gitignore").write_text("aos_gcs/api/static/\n*.so\n")
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", "dist", ".", cwd=clone)
    (built,) = (clone / "dist").glob("*.whl")
    return built


def test_the_wheel_holds_the_three_packages_and_the_page(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {"aos_gcs/api/static/index.html", "aos_gcs/api/static/assets/page.js"} <= set(names)
    assert {"aos_drivers/__init__.py", "aos_sim/__init__.py", "aos_gcs/py.typed"} <= set(names)
    folders = {name.split("/")[0] for name in names if ".dist-info/" not in name}
    assert folders == {"aos_gcs", "aos_drivers", "aos_sim"}


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_wheel_holds_the_kernels_for_its_kind_of_machine(wheel: Path) -> None:
    assert "aos_gcs/imaging/native/imaging-kernels.so" in zipfile.ZipFile(wheel).namelist()
    assert "-py3-none-" in wheel.name
    assert not wheel.name.endswith("-any.whl")


def test_a_wheel_without_compiler_has_no_kernels_and_fits_every_machine(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-compiler-of-this-name")
    built = build_wheel(tmp_path_factory.mktemp("without"))
    assert built.name.endswith("-py3-none-any.whl")


def test_the_service_installs_alone(wheel: Path, tmp_path: Path) -> None:
    venv.create(tmp_path / "venv", with_pip=True)
    programs = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    constraints = ROOT / "constraints.txt"
    run(programs / "python", "-m", "pip", "install", "--quiet", "--constraint", constraints, wheel, cwd=tmp_path)
    run(programs / "python", "-c", LEARN_NOTHING_OPTIONAL, cwd=tmp_path)
    assert "inspect" in run(programs / "aos-gcs", "--help", cwd=tmp_path)
