"""What commands import: the README's first command installs the simulator, ``pip install .`` no extra at all."""

from __future__ import annotations

import json
import subprocess
import sys

OF_EXTRAS = (
    "PIL",
    "argon2",
    "av",
    "contourpy",
    "cryptography",
    "dask",
    "distributed",
    "embreex",
    "ifaddr",
    "matplotlib",
    "mavsdk",
    "pmtiles",
    "pyarrow",
    "pymap3d",
    "pyproj",
    "rasterio",
    "reportlab",
    "segno",
)


def imported_without(modules: tuple[str, ...], work: str) -> str:
    """Return what a program prints in an interpreter to which these modules are not installed."""
    code = f"import sys; sys.modules.update(dict.fromkeys({modules}))\n{work}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)  # noqa: S603
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_demo_needs_no_library_of_other_extras_than_the_simulator() -> None:
    others = tuple(name for name in OF_EXTRAS if name not in {"embreex", "pmtiles"})
    imported_without(others, "import aos_gcs.runtime.simulated.demo, aos_sim.cli")


def test_every_command_can_be_loaded_without_any_extra() -> None:
    told = imported_without(
        OF_EXTRAS,
        "import json; from aos_gcs.cli import BUILT_IN; from aos_gcs.cli.registry import group_class\n"
        "commands = group_class(BUILT_IN)(name='aos-gcs').commands\n"
        "print(json.dumps({name: commands[name].help or '' for name in commands}))",
    )
    helps = json.loads(told)
    assert {"demo", "run", "integrate", "survey", "sim", "sim-camera", "lab"} <= helps.keys()
    assert {name: text for name, text in helps.items() if text.startswith("Unavailable")} == {}
