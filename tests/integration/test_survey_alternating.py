"""``aos-gcs survey`` of photographs of two drones in one folder, whose names alternate."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from aos_gcs.examination.survey_mission import SurveyMission
from aos_gcs.examination.windows import FrameWindow
from aos_gcs.store.reader import MissionReader
from tests.fakes.command_line import exit_status
from tests.fakes.survey_flight import Photographs

APART_DEG = 0.004
"""300 m of longitude: the second drone flies the same way over ground that looks the same."""


def survey(capfd: pytest.CaptureFixture[str], folder: Path, *options: object) -> dict[str, Any]:
    capfd.readouterr()
    assert exit_status(["--log-level", "error", "survey", str(folder), "--headless", "--json", *map(str, options)]) == 0
    result: dict[str, Any] = json.loads(capfd.readouterr().out)
    return result


def places(result: dict[str, Any]) -> list[tuple[float, float]]:
    """Return longitudes and latitudes of the findings, from west to east."""
    return sorted((one["longitude_deg"], one["latitude_deg"]) for one in result["findings"])


@pytest.fixture
def alternating(tmp_path: Path) -> Photographs:
    """Photographs 0a.jpg, 0b.jpg, 1a.jpg and so on: those of b lie 300 m east of those of a."""
    photographs = Photographs(tmp_path, hot=True)
    for index in range(6):
        name = f"{index}.jpg"
        image = np.asarray(cv2.imread(str(photographs.images / name), cv2.IMREAD_UNCHANGED), dtype=np.uint8)
        tags = photographs.tags[name]
        longitude = f"{float(tags['drone-dji:GpsLongitude']) + APART_DEG:.9f}"
        photographs.write(f"{index}a.jpg", image, tags)
        photographs.write(f"{index}b.jpg", image, tags | {"drone-dji:GpsLongitude": longitude})
        (photographs.images / name).unlink()
    return photographs


def test_drones_whose_names_alternate_are_examined_like_two_folders(
    alternating: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    alone = tmp_path / "alone"
    alone.mkdir()
    for path in sorted(alternating.images.glob("*a.jpg")):
        (alone / path.name).write_bytes(path.read_bytes())
    expected = survey(capfd, alone)
    result = survey(capfd, alternating.images)
    (place,) = places(expected)
    assert places(result) == [
        pytest.approx(place, abs=3e-7),
        pytest.approx((place[0] + APART_DEG, place[1]), abs=3e-7),
    ]
    assert result["windows"] == 2 * expected["windows"]
    assert result["message"] == expected["message"].replace("6 of 6", "12 of 12").replace(
        "1 possible person", "2 possible persons"
    )
    assert {one["reasons"][-1] for one in result["findings"]} == {
        "in the view of 4 pictures, 0a.jpg to 3a.jpg",
        "in the view of 4 pictures, 0b.jpg to 3b.jpg",
    }
    with MissionReader(Path(result["folder"])) as reader:
        kept = [(entry.step, entry.vehicle_id, entry.image_index) for entry in reader.frames()]
        names = reader.manifest()["pictures"]
    assert isinstance(names, list)
    assert [(step, number, names[index]) for step, number, index in kept] == [
        (step, number + 1, f"{number}{drone}.jpg") for step, drone in ((1, "a"), (2, "b")) for number in range(6)
    ]


def test_progress_says_that_pictures_of_others_lie_between(
    alternating: Photographs, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    told, update = [], SurveyMission.update

    async def listened(mission: SurveyMission, **changes: Any) -> None:
        told.append(changes.get("message"))
        await update(mission, **changes)

    monkeypatch.setattr(SurveyMission, "update", listened)
    survey(capfd, alternating.images)
    assert "Examining 6 of the pictures 1 to 11 of 12, window 1 of 2" in told
    assert "Examining 6 of the pictures 2 to 12 of 12, window 2 of 2" in told


def end_in_step(step: int, monkeypatch: pytest.MonkeyPatch, folder: Path, out: Path) -> None:
    observe = SurveyMission.observe

    def interrupted(mission: SurveyMission, targets: Any, number: int) -> Any:
        if number == step:
            raise KeyboardInterrupt
        return observe(mission, targets, number)

    with monkeypatch.context() as patched:
        patched.setattr(SurveyMission, "observe", interrupted)
        arguments = ["survey", str(folder), "--headless", "--json", "--out", str(out)]
        assert exit_status(["--log-level", "error", *arguments]) == 130


def test_an_examination_of_two_drones_that_was_ended_goes_on(
    alternating: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = tmp_path / "ended"
    end_in_step(2, monkeypatch, alternating.images, ended)
    again = survey(capfd, alternating.images, "--out", ended)
    assert len(places(again)) == again["windows"] == 2


def test_an_examination_that_was_begun_with_other_windows_is_not_continued(
    alternating: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before, a window ended at the first picture of another drone: what was done then is not what is done now."""
    ended = tmp_path / "ended"
    with monkeypatch.context() as patched:
        former = tuple(FrameWindow((first, first + 1)) for first in range(11))
        patched.setattr("aos_gcs.examination.prepare.plan_windows", lambda *_: former)
        end_in_step(3, monkeypatch, alternating.images, ended)
    capfd.readouterr()
    arguments = ["survey", str(alternating.images), "--headless", "--out", str(ended)]
    assert exit_status(["--log-level", "error", *arguments]) == 2
    assert "was begun by another version of aos-gcs" in capfd.readouterr().err
