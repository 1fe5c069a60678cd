"""What others have written: paths, and what they name."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from aos_gcs.errors import InputDataError
from aos_gcs.input_values import require_file, require_folder


def test_paths_that_name_something_else_are_not_said_to_be_absent(tmp_path: Path) -> None:
    file, pipe = tmp_path / "file", tmp_path / "pipe"
    file.touch()
    os.mkfifo(pipe)
    require_file(file, "The video")
    require_folder(tmp_path, "The image folder")
    with pytest.raises(InputDataError, match="The video cannot be read: it is not a file"):
        require_file(pipe, "The video")
    with pytest.raises(InputDataError, match="The image folder is a file; name the folder"):
        require_folder(file, "The image folder")
    for require in (require_file, require_folder):
        with pytest.raises(InputDataError, match="It does not exist; check the path"):
            require(tmp_path / "nowhere", "It")
