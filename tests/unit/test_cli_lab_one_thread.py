import subprocess
import sys

import pytest

from aos_gcs.cli.lab.one_thread import use_one_thread

COMMANDS = ("missions", "effectiveness")


@pytest.mark.parametrize("command", COMMANDS)
def test_numpy_is_not_imported_before_the_command_begins(command: str) -> None:
    code = f"import sys, aos_gcs.cli.lab.{command}; print('numpy' in sys.modules, 'cv2' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert done.stdout.split() == ["False", "False"]


def test_numerical_libraries_have_one_thread_unless_the_user_says_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    environment = {"OPENCV_FOR_THREADS_NUM": "3"}
    monkeypatch.setattr("os.environ", environment)
    use_one_thread()
    assert environment == {"OPENBLAS_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "3"}
