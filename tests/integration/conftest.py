"""Settings of the integration tests."""

from __future__ import annotations

import pytest

from aos_gcs.imaging import workers


@pytest.fixture(autouse=True)
def _one_imaging_thread(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compute the small images of missions in virtual time at once: threads take an eighth of their time."""
    if request.node.get_closest_marker("looptime") is not None:
        monkeypatch.setattr(workers, "_limits", [1])
