"""Settings of the integration tests."""

from __future__ import annotations

import pytest

from aos_gcs.imaging import workers
from tests.fakes.threaded_worker import open_threaded_worker


@pytest.fixture(autouse=True)
def _one_imaging_thread(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compute the small images of missions in virtual time at once: threads take an eighth of their time."""
    if any(request.node.get_closest_marker(name) is not None for name in ("looptime", "virtual")):
        monkeypatch.setattr(workers, "_limits", [1])


@pytest.fixture
def threaded_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the service compute in its own process, for tests of what happens before anything is computed."""
    monkeypatch.setattr("aos_gcs.runtime.service.open_worker", open_threaded_worker)
