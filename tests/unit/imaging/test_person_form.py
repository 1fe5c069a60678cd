"""Size and pattern of warmth of a body by all frames that show it, and what they say."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from operator import add

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.persons.decision import FORM_TOLD, SEVERAL_LOOKS, FindingKind, Verdict, decide, pooled
from aos_gcs.imaging.persons.evidence import gather_evidence
from aos_gcs.imaging.persons.form import MAX_VANTAGE_POINTS, Form, form_sums
from aos_gcs.imaging.persons.kinds import log_ratio
from aos_gcs.imaging.persons.warm_bodies import WarmView

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
UP_M = 35.0
FOOT_ENU_M = np.array([3.0, -2.0])
STANDING = Form(60, 0.5, 0.28, 0.14, 0.03, 7.0, 0.08)
DEER = Form(60, 1.0, 0.3, 0.07, 0.03, 5.0, 0.22)
STONE = Form(60, 0.6, 0.5, 0.03, 0.03, 1.4, 0.15)


def box(size_m: tuple[float, float, float], heading_rad: float = 0.0, points: int = 400) -> NDArray[np.float64]:
    """Points of a box that stands on the ground, its length towards the heading, shape (points, 3)."""
    rng = np.random.default_rng(3)
    right_m, front_m, up_m = (rng.uniform(-0.5, 0.5, (points, 3)) * size_m).T
    sin, cos = math.sin(heading_rad), math.cos(heading_rad)
    return np.column_stack((cos * right_m + sin * front_m, cos * front_m - sin * right_m, up_m + size_m[2] / 2))


def views_of(
    body_m: NDArray[np.float64],
    *,
    contrast_k: float | NDArray[np.float64] = 14.0,
    error_m: float = 0.0,
    share: float = 0.3,
    count: int = 60,
) -> list[WarmView]:
    """Views from all around, each of some of the points and displaced by an error of its pose."""
    rng = np.random.default_rng(5)
    contrasts_k = np.broadcast_to(contrast_k, len(body_m))
    views = []
    for index in range(count):
        bearing = 2.0 * math.pi * index / count
        camera_enu_m = np.array([*(FOOT_ENU_M + 10.0 * np.array([math.sin(bearing), math.cos(bearing)])), UP_M])
        seen = rng.random(len(body_m)) < share
        points_m, up_m = FOOT_ENU_M + body_m[seen, :2], body_m[seen, 2:]
        on_ground_m = camera_enu_m[:2] + (points_m - camera_enu_m[:2]) * UP_M / (UP_M - up_m)
        shifted_m = on_ground_m + rng.normal(0.0, error_m, 2)
        views.append(WarmView(index % 5, shifted_m, contrasts_k[seen].copy(), 0.004, CAMERA, nadir_pose(camera_enu_m)))
    return views


def form_of(views: Sequence[WarmView]) -> Form:
    form = form_sums(views, 0.0).form()
    assert form is not None
    return form


@pytest.mark.parametrize("error_m", [0.0, 0.7])
@pytest.mark.parametrize(
    ("size_m", "sigma_m2"), [((0.5, 0.3, 1.75), 0.02), ((0.35, 1.3, 0.9), 0.08), ((0.8, 0.9, 0.3), 0.04)]
)
def test_frames_from_all_sides_tell_length_width_and_height_whatever_their_poses_err(
    size_m: tuple[float, float, float], sigma_m2: float, error_m: float
) -> None:
    """The longer a body is, the less sure its height."""
    form = form_of(views_of(box(size_m, heading_rad=0.7), error_m=error_m))
    assert form.length_m == pytest.approx(max(size_m[:2]), rel=0.12)
    assert form.width_m == pytest.approx(min(size_m[:2]), rel=0.12)
    assert abs(form.heights_m2 - size_m[2] ** 2 / 12) < 3 * form.heights_sigma_m2
    assert 0.4 * sigma_m2 < form.heights_sigma_m2 < sigma_m2


def through_gaps(view: WarmView, gaps: int, rng: np.random.Generator) -> WarmView:
    """Return what some gaps between leaves leave of a view: two or three pixels each."""
    at = rng.choice(len(view.points_enu_m), gaps, replace=False)
    points_enu_m = np.repeat(view.points_enu_m[at], rng.integers(2, 4, gaps), axis=0)
    points_enu_m += rng.normal(0.0, 0.02, points_enu_m.shape)
    return replace(view, points_enu_m=points_enu_m, contrast_k=np.full(len(points_enu_m), 14.0))


@pytest.mark.parametrize("gaps", [3, 5, 10])
def test_a_body_is_as_large_through_few_gaps_as_through_many(gaps: int) -> None:
    """A boar of whom frames showed seven pixels each was as small as a person who sits (500 trees/ha, seed 418055)."""
    rng = np.random.default_rng(7)
    views = [through_gaps(view, gaps, rng) for view in views_of(box((0.4, 1.2, 0.7)), count=200)]
    form = form_of(views)
    assert form.length_m == pytest.approx(1.2, rel=0.12)
    assert abs(form.heights_m2 - 0.7**2 / 12) < 3 * form.heights_sigma_m2


@pytest.mark.parametrize(("pixel_area_m2", "fineness"), [(0.004, 1.0), (0.12, 0.1)])
def test_coarse_pixels_tell_less_of_a_form(pixel_area_m2: float, fineness: float) -> None:
    views = [replace(view, pixel_area_m2=pixel_area_m2) for view in views_of(box((0.5, 0.3, 1.75)))]
    assert form_of(views).fineness == pytest.approx(fineness)


def test_frames_from_above_do_not_tell_a_height() -> None:
    views = [
        replace(view, pose=nadir_pose([*FOOT_ENU_M, UP_M])) for view in views_of(box((0.5, 0.5, 0.0)), error_m=0.0)
    ]
    form = form_of(views)
    assert form.heights_m2 == pytest.approx(0.08, abs=0.01), "what is assumed before"
    assert form.heights_sigma_m2 > 0.1


@given(st.integers(1, 58))
def test_sums_of_two_parts_are_those_of_all(first: int) -> None:
    views = views_of(box((0.4, 1.0, 0.8)))
    together = form_of(views)
    parts = form_sums(views[:first], 0.0) + form_sums(views[first:], 0.0)
    form = parts.form()
    assert form is not None
    assert form.vantage_points == together.vantage_points
    assert (form.length_m, form.width_m, form.heights_m2, form.spread_k) == pytest.approx(
        (together.length_m, together.width_m, together.heights_m2, together.spread_k)
    )


def test_frames_from_one_place_count_once_however_many_they_are() -> None:
    """A vehicle that hovers sees the same part of a body through the same gap again and again."""
    views = views_of(box((0.4, 1.0, 0.8)), share=0.9)
    part = replace(views[0], points_enu_m=views[0].points_enu_m[:40], contrast_k=np.full(40, 30.0))
    once, often = form_of([*views[1:], part]), form_of([*views[1:], *[part] * 50])
    assert often == once
    elsewhere = replace(part, pose=nadir_pose(part.pose.position_enu_m + np.array([2.5, 0.0, 0.0])))
    assert form_of([*views[1:], part, elsewhere]).vantage_points == once.vantage_points + 1


def test_the_latest_vantage_points_are_kept() -> None:
    view = views_of(box((0.4, 1.0, 0.8)))[0]
    places = [replace(view, pose=nadir_pose([5.0 * index, 0.0, UP_M])) for index in range(200)]
    sums = reduce(add, (form_sums([place], 0.0) for place in places))
    assert sums.sums.keys() == form_sums(places[-MAX_VANTAGE_POINTS:], 0.0).sums.keys()


def test_what_is_hot_is_told_by_its_share_and_by_how_much_warmer_it_is() -> None:
    body_m = box((0.5, 0.5, 0.5), points=1000)
    contrast_k = np.where(np.arange(1000) < 100, 20.0, 13.0)
    form = form_of(views_of(body_m, contrast_k=contrast_k))
    assert form.spread_k == pytest.approx(7.0, abs=0.3)
    assert form.hot_share == pytest.approx(0.1, abs=0.02)
    assert form_of(views_of(body_m)).spread_k < 0.3


def test_the_edges_of_spots_in_images_out_of_focus_are_no_pattern_of_warmth() -> None:
    views = views_of(box((0.5, 0.5, 0.5)), contrast_k=np.linspace(9.0, 15.0, 400))
    spread_k = form_of(views).spread_k
    assert form_of([replace(view, out_of_focus=True) for view in views]).spread_k == pytest.approx(spread_k / 1.7)


def test_few_frames_pieces_of_a_few_pixels_and_several_bodies_in_one_tell_no_form() -> None:
    views = views_of(box((0.5, 0.5, 1.0)))
    assert form_sums([], 0.0).form() is None
    assert form_sums(views[:3], 0.0).form() is None
    assert form_sums([view.part(np.arange(2)) for view in views], 0.0).form() is None
    assert form_sums([replace(view, speed_mps=5.0) for view in views], 0.0).form() is None
    two = [replace(view, points_enu_m=view.points_enu_m * [1.0, 9.0]) for view in views]
    assert form_sums(two, 0.0).form() is None


def test_a_person_an_animal_and_a_stone_are_told_apart_by_their_form() -> None:
    assert log_ratio(STANDING) > 4.0
    assert log_ratio(DEER) < -4.0
    assert log_ratio(STONE) < -3.0
    assert log_ratio(Form(60, 1.4, 0.52, -0.03, 0.03, 8.0, 0.05)) > 3.0, "a person who lies"
    assert log_ratio(replace(STANDING, spread_k=0.8)) > 1.0, "one who is covered all over"


def test_spots_of_sun_tell_no_person_from_an_animal() -> None:
    """Fur in them is warmer by as much as skin is warmer than clothes: size alone remains."""
    boar = Form(14, 1.1, 0.42, 0.05, 0.14, 13.0, 0.04)
    assert log_ratio(boar) > 2.0, "as if that were skin"
    assert log_ratio(replace(boar, in_sun=1.0)) < 0.0
    assert log_ratio(replace(STANDING, spread_k=13.0, in_sun=1.0)) > 3.0
    assert log_ratio(replace(STONE, in_sun=1.0)) < -2.0


def test_the_share_of_pixels_in_the_sun_is_known() -> None:
    views = [replace(view, in_sun=index % 4 == 0) for index, view in enumerate(views_of(box((0.5, 0.5, 1.7))))]
    form = form_sums(views, 0.0).form()
    assert form is not None
    assert form.in_sun == pytest.approx(0.25, abs=0.05)
    assert not gather_evidence(views).in_sun
    assert gather_evidence(views[::4]).in_sun


def test_few_vantage_points_say_less() -> None:
    assert 0.0 < log_ratio(replace(STANDING, vantage_points=4, heights_sigma_m2=0.12)) < log_ratio(STANDING)


def looks(by_warmth: float, count: int = 10) -> list[Verdict]:
    kind = FindingKind.PERSON if by_warmth >= 0.5 else FindingKind.ANIMAL
    return [Verdict(kind, by_warmth, ("seen",), is_surely_other=by_warmth < 0.02, by_warmth=by_warmth)] * count


def test_a_deer_as_warm_as_a_person_is_none_and_a_person_on_a_warm_day_is_one() -> None:
    assert pooled(looks(0.97)).kind is FindingKind.PERSON
    assert pooled(looks(0.97), DEER).kind is not FindingKind.PERSON
    assert pooled(looks(0.02)).kind is FindingKind.ANIMAL
    assert pooled(looks(0.02), STANDING).kind is FindingKind.PERSON


@pytest.mark.parametrize("by_warmth", [0.02, 0.6, 0.97])
@pytest.mark.parametrize("form", [STANDING, DEER, STONE])
def test_temperatures_count_less_the_better_the_form_is_told(by_warmth: float, form: Form) -> None:
    def log_odds(seen: Form | None) -> float:
        stated = float(scipy.special.logit(pooled(looks(by_warmth), seen).probability))
        return stated / SEVERAL_LOOKS if stated > 0.0 else stated

    assert log_odds(form) == pytest.approx(0.4 * log_odds(None) + log_ratio(form))
    half = replace(form, vantage_points=FORM_TOLD // 2)
    assert log_odds(half) == pytest.approx(0.7 * log_odds(None) + 0.5 * log_ratio(half))
    coarse = replace(form, fineness=0.1)
    assert log_odds(coarse) == pytest.approx(0.94 * log_odds(None) + 0.1 * log_ratio(form))


def test_coarse_pixels_do_not_tell_whether_skin_shows() -> None:
    uniform = [replace(one, is_uniform=True) for one in looks(0.9)]
    coarse = replace(STANDING, fineness=0.1)
    assert pooled(uniform, STANDING).probability == pooled(looks(0.9), STANDING).probability
    assert not pooled(uniform, coarse).is_sure
    assert pooled(looks(0.9), coarse).is_sure


def test_patterns_are_others_in_images_out_of_focus() -> None:
    """The middle of what leaves leave of a stone is cooler than the stone, and its spread as large as an animal's."""
    stone = replace(STONE, spread_k=3.4)
    assert log_ratio(replace(stone, out_of_focus=1.0)) < 0.0 < log_ratio(stone)


def test_what_has_the_form_of_a_person_is_never_surely_something_else() -> None:
    assert pooled(looks(0.01)).is_surely_other
    assert not pooled(looks(0.01), STANDING).is_surely_other
    assert pooled(looks(0.01), DEER).is_surely_other


def test_the_decision_about_a_look_uses_its_form_and_names_the_size() -> None:
    body_m = box((0.5, 0.3, 1.75), points=1000)
    contrast_k = np.where(np.arange(1000) < 80, 17.0, 10.0)
    views = views_of(body_m, contrast_k=contrast_k)
    evidence = gather_evidence(views, views)
    verdict, by_warmth = decide(evidence), decide(replace(evidence, form=None))
    assert verdict.by_warmth == by_warmth.probability
    assert (verdict.probability or 0.0) > (by_warmth.probability or 0.0)
    assert "0.5 by 0.3 m seen from above, 1.8 m high" in verdict.reasons[-1]
    assert "m long" in by_warmth.reasons[-1]


def test_heights_that_vary_by_less_than_nothing_say_no_more() -> None:
    """The variance of heights of a boar that stands between leaves was told as -0.15 m², which is nobody's."""
    boar = replace(DEER, heights_m2=-0.15, length_m=1.25, width_m=0.5, spread_k=5.2, hot_share=0.2)
    assert log_ratio(boar) == log_ratio(replace(boar, heights_m2=-0.5)) == log_ratio(replace(boar, heights_m2=-0.05))
    assert log_ratio(boar) > log_ratio(replace(boar, heights_m2=0.0))


def test_two_persons_side_by_side_are_persons_and_two_deer_or_a_trunk_are_none() -> None:
    """Two persons 1.6 m apart were one body 3.2 m long, which was taken for nothing known, and not announced."""
    two = Form(20, 3.2, 0.8, -0.29, 0.15, spread_k=7.4, hot_share=0.12)
    assert log_ratio(two) > 0.4
    assert log_ratio(replace(two, spread_k=4.6, hot_share=0.25)) < -1.0
    assert log_ratio(replace(two, spread_k=1.4, hot_share=0.15)) < -1.0
