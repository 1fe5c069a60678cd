"""The example of a strategy of one's own: short, and compared in the laboratory once it is installed."""

import os
import shutil
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from aos_gcs.swarm import registry
from aos_gcs.swarm.model import Observation

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "custom_strategy"


def test_the_example_is_short() -> None:
    assert len((EXAMPLE / "ring_strategy.py").read_text(encoding="utf-8").splitlines()) < 50


def test_the_example_stands_in_a_ring_around_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    entry_point = EntryPoint("ring", "ring_strategy:make_ring", registry.GROUP)
    monkeypatch.setattr(registry, "entry_points", lambda **_: (entry_point,))
    strategy = registry.make_strategy("ring", {"c4_m": 5.0})
    line_m = np.column_stack([5.0 * np.arange(8), np.zeros(8)])
    target_m = np.array([10.0, 30.0])
    seen = Observation(tuple(range(1, 9)), line_m, np.ones(8), target_in_view=True, target_enu_m=target_m)
    state = strategy.tell(strategy.init(np.array([0.0, 1.0])), seen)
    ring_m, state = strategy.ask(state, np.random.default_rng(0))
    assert np.ptp(np.linalg.norm(ring_m - target_m, axis=1)) < 1e-9
    assert pdist(ring_m).min() == pytest.approx(5.0)
    assert strategy.diagnostics(state).branch == "ring"


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_example_is_installed_and_compared(tmp_path: Path) -> None:
    pytest.importorskip("embreex", reason="the laboratory needs the extra lab")
    site = tmp_path / "site"
    shutil.copytree(EXAMPLE, tmp_path / "example")
    environment = {**os.environ, "PYTHONPATH": str(site)}
    run = [sys.executable, "-m", "aos_gcs", "lab", "run", "--strategies", "aos-pso,ring(c4_m=5)"]
    for command in (
        [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", site, tmp_path / "example"],
        [*run, "--initialisations", "1", "--duration", "5", "--out", tmp_path / "campaign"],
        [sys.executable, "-m", "aos_gcs", "lab", "report", tmp_path / "campaign", "--runs", "0"],
    ):
        done = subprocess.run(  # noqa: S603
            [str(part) for part in command], env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
    assert "ring(c4_m=5)" in Path(done.stdout.strip()).read_text(encoding="utf-8")
