"""The command line, run in the process of the tests."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from aos_gcs.cli import main


def exit_status(arguments: Iterable[object]) -> int:
    """Run a command, and return its exit status."""
    with pytest.raises(SystemExit) as stop:
        main([str(one) for one in arguments])
    assert isinstance(stop.value.code, int)
    return stop.value.code
