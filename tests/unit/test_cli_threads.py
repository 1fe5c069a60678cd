import subprocess
import sys

import pytest

from aos_gcs.cli import main
from aos_gcs.cli.threads import use_one_opencv_thread


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
