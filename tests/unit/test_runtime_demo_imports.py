"""What ``make demo`` imports: the README's first command installs no more than the simulator."""

import subprocess
import sys

OF_OTHER_EXTRAS = (
    "pyarrow",
    "dask",
    "distributed",
    "matplotlib",
    "mavsdk",
    "av",
    "reportlab",
    "rasterio",
    "pyproj",
    "contourpy",
)


def test_the_demo_needs_no_library_of_other_extras_than_the_simulator() -> None:
    code = f"import sys; sys.modules.update(dict.fromkeys({OF_OTHER_EXTRAS})); import aos_gcs.runtime.demo, aos_sim.cli"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)  # noqa: S603
    assert done.returncode == 0, done.stderr
