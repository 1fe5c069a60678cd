"""The study behind the probability of detection: what counts as noticed, the fit, and the honesty of its figures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import plane_to_image
from aos_gcs.groundmap.detection import DETECTABILITY, Detectability, Posture, detection_by_views
from aos_gcs.groundmap.directions import ViewDirections
from aos_gcs.lab.detectability import study
from aos_gcs.lab.detectability.calibration import (
    DetectionTrials,
    calibrate,
    fit,
    looks_at,
    occlusion_by_density,
    predicted,
)
from aos_gcs.lab.detectability.store import DetectabilityFolder
from aos_gcs.lab.detectability.study import (
    DetectabilitySettings,
    ForestKey,
    WatchedForest,
    WatchedPerson,
    forest_keys,
    watch_forest,
)
from aos_gcs.lab.worlds import Target, World, WorldParameters
from tests.fakes.command_line import exit_status
from tests.fakes.lab_world import FakeWorld

ONE_SQUARE = ViewDirections(0.5)


def person(*marked: Sequence[int], posture: Posture = Posture.LYING, **changes: object) -> WatchedPerson:
    """Return a person whose views lie in directions of their own and have marked these cells of 0.01 m²."""
    tangents = tuple((0.1 + 0.5 * (view % 2), 0.1 - 0.5 * (view // 2 % 2)) for view in range(len(marked)))
    whole = WatchedPerson(
        posture=posture,
        along_line=False,
        tangents=tangents,
        marked=tuple(map(tuple, marked)),
        seen_m2=(0.2,) * len(marked),
        whole_m2=(0.8,) * len(marked),
        cell_m2=0.01,
    )
    return replace(whole, **changes)  # type: ignore[arg-type]


def forest(*persons: WatchedPerson, seed: int = 1, trees_per_ha: float = 300.0) -> WatchedForest:
    return WatchedForest(ForestKey(trees_per_ha, seed), persons)


def looks(*persons: WatchedPerson, threshold_m2: float = 0.05) -> DetectionTrials:
    forests = [forest(*persons)]
    return looks_at(forests, Posture.LYING, {300.0: 0.75}, threshold_m2=threshold_m2, directions=ONE_SQUARE)


def test_a_person_is_noticed_when_the_marks_together_reach_the_area() -> None:
    halves = looks(person((1, 2, 3), (3, 4, 5)))
    assert not halves.noticed[halves.views == 1].any()
    assert halves.noticed[halves.views == 2].all()
    same = looks(person((1, 2, 3), (1, 2, 3)))
    assert not same.noticed.any(), "the same cells twice are no larger"


def test_views_in_one_square_of_directions_are_one_view() -> None:
    together = person(
        (1,), (2,), (3,), (4,), (5,), tangents=((0.1, 0.1), (0.2, 0.1), (0.1, 0.2), (0.3, 0.3), (0.4, 0.1))
    )
    found = looks(together)
    assert set(found.views) == {1}
    assert 0.0 < found.noticed.mean() < 1.0


def test_other_postures_are_left_out_and_lying_ones_tell_the_occlusion() -> None:
    standing = person((1,) * 9, posture=Posture.STANDING, seen_m2=(0.0,))
    forests = [forest(person((1,), (2,)), standing), forest(person((1,), seen_m2=(0.4,)), trees_per_ha=150.0)]
    occlusion = occlusion_by_density(forests)
    assert occlusion == pytest.approx({150.0: 0.5, 300.0: 0.75})
    found = looks_at(forests[:1], Posture.LYING, occlusion, threshold_m2=0.05, directions=ONE_SQUARE)
    assert set(found.occlusion) == {0.75}
    assert not found.noticed.any()


def drawn(law: Detectability, count: int = 4000) -> DetectionTrials:
    """Return looks whose outcomes are drawn by a law."""
    rng = np.random.default_rng(3)
    views, occlusion = rng.integers(1, 20, count), rng.choice([0.5, 0.8, 0.95], count)
    empty = DetectionTrials(views, occlusion, np.zeros(count, dtype=np.bool_))
    return replace(empty, noticed=rng.uniform(size=count) < predicted(empty, law))


@pytest.mark.parametrize("law", [DETECTABILITY[Posture.STANDING], Detectability(0.5, 0.9, 1.6)])
def test_the_fit_finds_the_law_that_the_outcomes_were_drawn_by(law: Detectability) -> None:
    observed = drawn(law)
    found = fit(observed)
    for occlusion in (0.5, 0.8, 0.95):
        assert detection_by_views(occlusion, found)[:20] == pytest.approx(
            detection_by_views(occlusion, law)[:20], abs=0.06
        )
    assert calibrate(observed, predicted(observed, found)).error < 0.03


def test_a_law_that_promises_too_much_has_a_large_error() -> None:
    observed = drawn(Detectability(0.2, 0.6, 1.0))
    bold = calibrate(observed, predicted(observed, Detectability(1.0, 0.6, 1.0)))
    assert bold.error > 0.2
    assert all(mean > share for mean, share, _ in bold.bins)
    assert sum(count for *_, count in bold.bins) == 4000


@dataclass(frozen=True)
class LitWorld(FakeWorld):
    """A world whose images show the seen part of the target as an anomaly, on a background of noise."""

    def render(
        self, poses: Sequence[Pose], camera: CameraModel, target: Target | None, rng: np.random.Generator
    ) -> list[NDArray[np.float32]]:
        assert target is not None
        shown = self.view_target(poses, camera, target)
        images = []
        for pose, seen in zip(poses, shown.seen, strict=True):
            image = rng.normal(100.0, 2.0, (512, 512, 4)).astype(np.float32)
            rows, columns = np.nonzero(seen)
            places = np.stack(
                (
                    shown.west_m + (columns + 0.5) * shown.resolution_m,
                    shown.north_m - (rows + 0.5) * shown.resolution_m,
                    np.ones(len(rows)),
                )
            )
            u, v, w = plane_to_image(camera, pose, 0.0) @ places
            image[np.rint(v / w).astype(int), np.rint(u / w).astype(int)] += 60.0
            images.append(image)
        return images


def test_what_is_marked_of_a_person_is_what_the_forest_leaves_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def build(parameters: WorldParameters) -> World:
        share = 0.6 if parameters.trees_per_ha < 200.0 else 0.0
        return LitWorld(seen=lambda _: share, reach_m=math.inf)

    monkeypatch.setattr(study, "build_world", build)
    settings = DetectabilitySettings(places=2, views=2)
    thin, dense = (watch_forest(settings, key) for key in forest_keys([150.0, 500.0], 1, 5))
    assert thin == watch_forest(settings, ForestKey(150.0, 5)), "the same again"
    assert [one.along_line for one in thin.persons] == [False] * 3 + [True] * 3
    for one in thin.persons:
        assert one.seen_m2 == pytest.approx((0.6, 0.6))
        assert one.whole_m2 == pytest.approx((1.0, 1.0))
        assert all(0.3 <= len(marked) * one.cell_m2 <= 0.75 for marked in one.marked)
    assert all(len(marked) * one.cell_m2 < 0.02 for one in dense.persons for marked in one.marked)


def test_a_study_goes_on_where_it_was_stopped_and_reports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from importlib.metadata import version  # noqa: PLC0415

    folder = DetectabilityFolder(tmp_path / "s", DetectabilitySettings(version=version("aos-gcs")))
    rng = np.random.default_rng(1)
    for key in forest_keys([150.0, 300.0], 4, 10):
        share = 0.1 if key.trees_per_ha == 150.0 else 0.03
        persons = [
            person(*(tuple(np.flatnonzero(rng.uniform(size=30) < share).tolist()) for _ in range(8)), posture=posture)
            for posture in Posture
        ]
        folder.append(WatchedForest(key, tuple(persons)))
    assert folder.forests()[0].persons[0].posture is Posture.STANDING
    arguments = ["lab", "detectability", "--out", str(tmp_path / "s"), "--forests", "4", "--seed", "10"]
    assert exit_status([*arguments, "--densities", "150,300"]) == 0
    told = capsys.readouterr().out
    assert "8 forests" in told
    assert "| standing | 8 |" in told


@pytest.mark.parametrize(("name", "value"), [("places", 1), ("views", 101)])
def test_settings_out_of_range_are_refused_by_name(name: str, value: int) -> None:
    with pytest.raises(ConfigurationError, match=name):
        DetectabilitySettings(**{name: value})  # type: ignore[arg-type]
