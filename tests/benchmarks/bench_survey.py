"""Peak memory and time of ``aos-gcs integrate`` on short and long surveys: python tests/benchmarks/bench_survey.py.

Every run is a process of its own. Baseline is a process that only imports the command's modules.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

from aos_gcs.geometry.poses import nadir_pose

FRAMES = (200, 2000)
SIZE_PX = 640
LENGTH_M, WIDTH_M = 80.0, 20.0
"""Sides of the area flown over, whatever the number of frames: maps are alike."""

RUN = """
import resource, sys
from aos_gcs.cli import main
import aos_gcs.cli.integrate
try:
    if len(sys.argv) > 1:
        main(["--log-level", "error", "integrate", *sys.argv[1:]])
except SystemExit as stop:
    assert not stop.code
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def main() -> None:
    table = Table("frames", "options", "map, cells", "seconds", "peak MB", "above baseline MB")
    baseline_mb, _, _ = run([])
    with tempfile.TemporaryDirectory() as folder:
        for frames in FRAMES:
            arguments = record(Path(folder) / str(frames), frames)
            for options in ([], ["--max-memory", "50"]):
                peak_mb, seconds, told = run([*arguments, *options])
                cells = told.partition("map: ")[2].partition(" cells")[0]
                above = f"{peak_mb - baseline_mb:.0f}"
                table.add_row(str(frames), " ".join(options), cells, f"{seconds:.1f}", f"{peak_mb:.0f}", above)
    Console(width=120).print(f"Baseline (imports): {baseline_mb:.0f} MB", table)


def record(folder: Path, frames: int) -> list[str]:
    """Write a survey of images of noise; return the arguments for a map."""
    images = folder / "images"
    images.mkdir(parents=True)
    rng = np.random.default_rng(0)
    distinct = [cv2.imencode(".jpg", rng.integers(0, 255, (SIZE_PX, SIZE_PX, 3), dtype=np.uint8))[1] for _ in range(20)]
    entries = []
    for index in range(frames):
        pose = nadir_pose([LENGTH_M * index / (frames - 1), WIDTH_M * (index % 3) / 2, 35.0])
        (images / f"{index:05}.jpg").write_bytes(distinct[index % len(distinct)].tobytes())
        M = np.column_stack((pose.R_cam2enu.T, -pose.R_cam2enu.T @ pose.position_enu_m))
        entries.append({"imagefile": f"{index:05}.jpg", "M3x4": M.tolist()})
    poses = folder / "poses.json"
    poses.write_text(json.dumps({"images": entries}))
    out = ["--ortho", "0.05", "--plane-z", "0", "--out", str(folder / "map.npy")]
    return [str(images), "--poses", str(poses), "--fov", "50", *out]


def run(arguments: list[str]) -> tuple[float, float, str]:
    """Return the peak memory in MB, the seconds, and what was told."""
    started_s = time.perf_counter()
    done = subprocess.run(  # noqa: S603 - our own program
        [sys.executable, "-c", RUN, *arguments], check=True, capture_output=True, text=True
    )
    unit = 1 << 20 if sys.platform == "darwin" else 1 << 10
    return int(done.stdout) / unit, time.perf_counter() - started_s, done.stderr


if __name__ == "__main__":
    main()
