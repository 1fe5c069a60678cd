"""Threads of libraries, and what later collections of the service's garbage leave out."""

from __future__ import annotations

import gc
import subprocess
import sys
import weakref

import pytest

from aos_gcs.cli import main
from aos_gcs.process import settle_garbage, use_one_opencv_thread


@pytest.mark.parametrize("module", ["aos_gcs.cli", "aos_gcs.cli.lab.missions", "aos_gcs.cli.lab.effectiveness"])
def test_numpy_is_not_imported_before_a_command_begins(module: str) -> None:
    code = f"import sys, {module}; print('numpy' in sys.modules, 'cv2' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert done.stdout.split() == ["False", "False"]


@pytest.mark.parametrize(("told", "used"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_every_command_computes_with_one_blas_thread_unless_the_user_says_otherwise(
    monkeypatch: pytest.MonkeyPatch, told: dict[str, str], used: str
) -> None:
    environment = dict(told)
    monkeypatch.setattr("os.environ", environment)
    with pytest.raises(SystemExit):
        main(["--no-such-option"])
    assert environment["OPENBLAS_NUM_THREADS"] == used


@pytest.mark.parametrize(("told", "used"), [({}, "1"), ({"OPENCV_FOR_THREADS_NUM": "3"}, "3")])
def test_studies_keep_opencv_from_threads_too(monkeypatch: pytest.MonkeyPatch, told: dict[str, str], used: str) -> None:
    environment = dict(told)
    monkeypatch.setattr("os.environ", environment)
    use_one_opencv_thread()
    assert environment == {"OPENCV_FOR_THREADS_NUM": used}


class Node:
    """Something that refers to itself."""

    def __init__(self) -> None:
        self.itself = self


def test_what_exists_is_left_out_and_what_comes_later_is_collected() -> None:
    before = Node()
    settle_garbage()
    assert not any(found is before for found in gc.get_objects())
    later = Node()
    assert any(found is later for found in gc.get_objects())
    lives = weakref.ref(later)
    del later
    gc.collect()
    assert lives() is None


def test_the_next_sortie_collects_what_the_former_one_has_left() -> None:
    former = Node()
    settle_garbage()
    lives = weakref.ref(former)
    del former
    gc.collect()
    assert lives() is not None
    settle_garbage()
    assert lives() is None
