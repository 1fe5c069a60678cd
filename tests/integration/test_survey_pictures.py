"""Pictures that do not fit the others of a recording, in ``aos-gcs integrate`` and ``survey``."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.examination.survey_mission import SurveyMission
from aos_gcs.mission.model.steps import StepRecord
from tests.fakes.command_line import exit_status
from tests.fakes.recorded_flight import Flight
from tests.fakes.survey_flight import Photographs

COLOURS = (1.0, 0.5, 0.25)


@pytest.fixture
def photographs(tmp_path: Path) -> Photographs:
    """Photographs in colours with the noise of a camera."""
    photographs, rng = Photographs(tmp_path, hot=True), np.random.default_rng(0)
    for name in list(photographs.tags):
        grey = pixels(photographs, name).astype(np.float64)
        noisy = np.dstack([share * grey for share in COLOURS]) + rng.normal(0.0, 3.0, (*grey.shape, 3))
        write(photographs, name, np.clip(noisy, 0, 255).astype(np.uint8))
    return photographs


def pixels(photographs: Photographs, name: str) -> NDArray[np.uint8]:
    image = cv2.imread(str(photographs.images / name), cv2.IMREAD_GRAYSCALE)
    return np.asarray(image, dtype=np.uint8)


def write(photographs: Photographs, name: str, image: NDArray[np.uint8]) -> None:
    photographs.write(name, image, photographs.tags[name])


def survey(capfd: pytest.CaptureFixture[str], folder: Path, *options: object) -> tuple[dict[str, Any], str]:
    """Examine a folder; return what is printed, and the lines on standard error."""
    capfd.readouterr()
    assert (
        exit_status(["--log-level", "warning", "survey", str(folder), "--headless", "--json", *map(str, options)]) == 0
    )
    captured = capfd.readouterr()
    return json.loads(captured.out), captured.err


@pytest.mark.parametrize(
    ("kind", "reason"),
    [
        ("grey", "it is grey with 8-bit values, where most pictures are in colour"),
        ("black", "it is the same everywhere"),
    ],
)
def test_an_odd_first_photograph_is_left_out_and_named(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], kind: str, reason: str
) -> None:
    grey = pixels(photographs, "0.jpg")
    write(photographs, "0.jpg", grey if kind == "grey" else np.zeros((*grey.shape, 3), np.uint8))
    result, errors = survey(capfd, photographs.images)
    assert len(result["findings"]) == 1
    assert result["message"].startswith("5 of 6 pictures examined: 1 possible person")
    assert "left out" not in result["message"]
    assert f"1 of 6 images are skipped; 0.jpg: {reason}" in errors
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 0
    assert f"1 of 6 images are skipped; 0.jpg: {reason}" in capfd.readouterr().err


def test_a_survey_says_that_it_leaves_out_many_pictures(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One is known to be odd when the folder is opened, another one when it is read."""
    monkeypatch.setattr("aos_gcs.surveys.kinds.SAMPLE", 1)
    write(photographs, "4.jpg", pixels(photographs, "4.jpg"))
    photographs.strip("5.jpg", "GpsLatitude")
    result, errors = survey(capfd, photographs.images)
    expected = r"2 of 6 pictures are left out; 5\.jpg: it has no GPSLatitude and GPSLongitude\.$"
    assert result["message"].startswith("4 of 6 pictures examined: ")
    assert re.search(expected, result["message"]), result["message"]
    assert re.search(expected, errors, re.MULTILINE), errors


def test_a_survey_that_goes_on_knows_what_was_left_out_before(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aos_gcs.surveys.kinds.SAMPLE", 1)
    monkeypatch.setattr("aos_gcs.examination.windows.MAX_REACH", 0.3)
    for name in ("1.jpg", "3.jpg"):
        write(photographs, name, pixels(photographs, name))
    arguments = ["survey", str(photographs.images), "--headless", "--json"]
    with monkeypatch.context() as patched:
        add_step = SurveyMission.add_step

        async def interrupted(mission: SurveyMission, record: StepRecord) -> None:
            if record.step == 3:
                raise KeyboardInterrupt
            await add_step(mission, record)

        patched.setattr(SurveyMission, "add_step", interrupted)
        assert exit_status(["--log-level", "error", *arguments]) == 130
    result, _ = survey(capfd, photographs.images)
    assert result["message"].startswith("4 of 6 pictures examined: ")
    assert "2 of 6 pictures are left out; 1.jpg: The image " in result["message"]


def test_pictures_of_other_sensors_are_not_missed(photographs: Photographs, capfd: pytest.CaptureFixture[str]) -> None:
    for name in ("0.jpg", "1.jpg", "2.jpg"):
        (photographs.images / name).rename(photographs.images / f"DJI_{name[0]}_T.JPG")
    for name in ("3.jpg", "4.jpg", "5.jpg"):
        (photographs.images / name).rename(photographs.images / f"DJI_{name[0]}_W.JPG")
    result, errors = survey(capfd, photographs.images, "--sensor", "wide")
    assert result["message"].startswith("3 of 3 pictures examined: ")
    assert "left out" not in result["message"] + errors


def test_black_photographs_are_refused(photographs: Photographs, capfd: pytest.CaptureFixture[str]) -> None:
    for name in list(photographs.tags):
        write(photographs, name, np.zeros((*pixels(photographs, name).shape, 3), np.uint8))
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 2
    errors = capfd.readouterr().err
    expected = (
        r"None of the 6 photographs in .* can be used; 0\.jpg: it is the same everywhere .* Was the lens covered\?"
    )
    assert re.search(expected, errors), errors


def test_an_odd_first_image_of_a_poses_file_is_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    flight = Flight(tmp_path)
    assert exit_status(flight.arguments()) == 0
    cv2.imwrite(str(flight.images / "0.png"), np.zeros((50, 60, 3), dtype=np.uint8))
    flight.out.unlink()
    assert exit_status(flight.arguments()) == 2
    assert "0.png has 60 x 50 pixels" in capfd.readouterr().err
    assert exit_status(flight.arguments(skip_broken=True)) == 0
    assert "1 of 4 images are skipped; 0.png: " in capfd.readouterr().err
    assert np.isfinite(np.load(flight.out)).any()
