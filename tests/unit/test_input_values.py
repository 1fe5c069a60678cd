"""What others have written: paths, and what they name."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from aos_gcs.errors import InputDataError
from aos_gcs.input_values import problem_texts, require_file, require_folder


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


class Document(BaseModel):
    model_config = ConfigDict(extra="forbid")

    count: int = Field(0, ge=1, le=9)
    share: float = Field(0.5, gt=0.0, lt=1.0, allow_inf_nan=False)
    is_on: bool = True
    name: str = Field("name", min_length=2, max_length=4)
    places: list[tuple[float, float]] = Field([(0.0, 0.0)], min_length=1, max_length=2)
    inner: Document | None = None


@pytest.mark.parametrize(
    ("document", "text"),
    [
        ({"count": 0}, "count must be at least 1"),
        ({"count": 10}, "count must be at most 9"),
        ({"count": "many"}, "count must be a whole number"),
        ({"share": 0.0}, "share must be above 0"),
        ({"share": 1.0}, "share must be below 1"),
        ({"share": float("nan")}, "share must be a finite number"),
        ({"is_on": 7}, "is_on must be true or false"),
        ({"name": "n"}, "name must have 2 characters or more"),
        ({"name": "names"}, "name must have 4 characters at most"),
        ({"name": 3}, "name must be text"),
        ({"places": []}, "places must have 1 entries or more, but has 0"),
        ({"places": [[0.0, "x"]]}, "places[0][1] must be a number"),
        ({"places": 5}, "places must be a list"),
        ({"inner": {"other": 1}}, "inner.other is unknown; check its name"),
        (5, "The file must be a table"),
    ],
)
def test_problems_of_documents_are_told_in_plain_words(document: object, text: str) -> None:
    with pytest.raises(ValidationError) as refused:
        Document.model_validate(document)
    assert problem_texts(refused.value.errors(), "The file") == [text]
