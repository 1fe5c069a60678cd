"""Whether a target looks like a person, by what was warm in the latest steps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.decision import FindingKind, Verdict
from aos_gcs.mission.search.targets.persons import KEPT_STEPS, PersonWatch, watch_persons

CAMERA = CameraModel.from_fov(256, 256, math.radians(50.0))
PLACE_ENU_M = np.array([2.0, -1.0])
HEIGHT_M = 35.0
COLOURS = ("red", "green", "blue")


def warm_frame(vehicle_id: int, *, clothes_k: float, skin_k: float, size_m: float = 0.5) -> Frame:
    """Forest of 11 °C with a warm square at the place, warmest at its northern edge."""
    gsd_m = HEIGHT_M / CAMERA.fx_px
    image = np.random.default_rng(vehicle_id).normal(11.0, 0.1, (256, 256, 1))
    column = round(PLACE_ENU_M[0] / gsd_m + CAMERA.cx_px)
    row = round(-PLACE_ENU_M[1] / gsd_m + CAMERA.cy_px)
    half = round(size_m / gsd_m / 2)
    image[row - half : row + half + 1, column - half : column + half + 1] = 11.0 + clothes_k
    image[row - half, column - half : column + half + 1] = 11.0 + skin_k
    return Frame(vehicle_id, image.astype(np.float32), ("thermal",), nadir_pose([0.0, 0.0, HEIGHT_M]), CAMERA)


def in_part_warmer(frame: Frame, kelvin: float) -> Frame:
    """The frame with a western fifth in the sun."""
    image = frame.image.astype(np.float32)
    image[:, : image.shape[1] // 5] += kelvin
    return replace(frame, image=image)


def person(vehicle_id: int) -> Frame:
    return warm_frame(vehicle_id, clothes_k=11.0, skin_k=20.0)


def verdict_at(watch: PersonWatch, place_enu_m: np.ndarray = PLACE_ENU_M) -> Verdict | None:
    judgement = watch.judge({7: place_enu_m}, 0.0, Uncertainty()).get(7)
    return None if judgement is None else judgement.verdict


def test_a_body_as_warm_as_skin_and_clothes_is_taken_for_a_person_and_a_lukewarm_stone_is_not() -> None:
    verdict = verdict_at(PersonWatch().look([person(1), person(2), person(3)], 0.0))
    assert verdict is not None
    assert verdict.kind is FindingKind.PERSON
    assert "seen in 3 of 3 frames" in verdict.reasons
    stones = [warm_frame(vehicle_id, clothes_k=5.0, skin_k=5.0, size_m=0.3) for vehicle_id in (1, 2, 3)]
    verdict = verdict_at(PersonWatch().look(stones, 0.0))
    assert verdict is not None
    assert verdict.kind is FindingKind.WARM_OBJECT


def test_a_day_is_sunny_by_all_frames_of_the_search() -> None:
    """Also where all that the latest frames hold lies in the shade."""
    shade = [person(vehicle_id) for vehicle_id in (1, 2, 3)]
    lit = [in_part_warmer(frame, 3.0) for frame in shade]
    watch = PersonWatch().look(lit, 0.0).look(shade, 0.0)
    assert all(view.in_sun for view in watch.on_plane(1.0).look(shade, 1.0).steps[-1])
    assert not any(view.in_sun for view in PersonWatch().look([*shade, *shade, *shade, lit[0]], 0.0).steps[-1])


def test_the_body_is_located_and_a_frame_that_does_not_show_it_counts_among_those_that_look() -> None:
    hidden = replace(person(4), image=np.full((256, 256, 1), 11.0, np.float32))
    judgement = PersonWatch().look([person(1), person(2), hidden], 0.0).judge({7: PLACE_ENU_M}, 0.0, Uncertainty())[7]
    assert judgement.place is not None
    assert np.allclose(judgement.place.position_enu_m[:2], PLACE_ENU_M, atol=0.3)
    assert "seen in 2 of 3 frames" in judgement.verdict.reasons


def test_a_place_without_anything_warm_is_no_person_and_one_that_no_frame_holds_gets_no_verdict() -> None:
    watch = PersonWatch().look([person(1), person(2)], 0.0)
    verdict = verdict_at(watch, PLACE_ENU_M + 5.0)
    assert verdict is not None
    assert (verdict.kind, verdict.probability) == (FindingKind.OBJECT, 0.0)
    assert verdict_at(watch, PLACE_ENU_M + 500.0) is None
    assert watch.judge({}, 0.0, Uncertainty()) == {}


def test_frames_in_colour_cannot_tell() -> None:
    frames = [
        replace(frame, image=np.repeat(frame.image, 3, axis=2), bands=COLOURS) for frame in (person(1), person(2))
    ]
    verdict = verdict_at(PersonWatch().look(frames, 0.0))
    assert verdict == Verdict(FindingKind.ANOMALY, None, ("no temperatures to judge it by",))


def grey_levels(
    vehicle_id: int, *, spot: float, place_enu_m: np.ndarray = PLACE_ENU_M, bands: str = "thermal"
) -> Frame:
    """Forest of grey level 100 ± 5 with a spot of 0.7 m that many levels brighter at a place."""
    gsd_m = HEIGHT_M / CAMERA.fx_px
    image = np.random.default_rng(vehicle_id).normal(100.0, 5.0, (256, 256, 1))
    column = round(place_enu_m[0] / gsd_m + CAMERA.cx_px)
    row = round(-place_enu_m[1] / gsd_m + CAMERA.cy_px)
    image[row - 2 : row + 3, column - 2 : column + 3] += spot
    return Frame(vehicle_id, image.astype(np.uint8), (bands,), nadir_pose([0.0, 0.0, HEIGHT_M]), CAMERA)


def test_a_spot_that_several_grey_frames_show_at_one_place_counts_as_a_find_without_a_probability() -> None:
    watch = PersonWatch().look([grey_levels(number, spot=50.0) for number in (1, 2, 3)], 0.0)
    judgement = watch.judge({7: PLACE_ENU_M + 0.3}, 0.0, Uncertainty())[7]
    assert (judgement.verdict.kind, judgement.verdict.probability) == (FindingKind.ANOMALY, None)
    assert "seen in 3 of 3 frames" in judgement.verdict.reasons
    assert "no temperatures, so no probability" in judgement.verdict.reasons
    assert judgement.place is not None
    assert np.allclose(judgement.place.position_enu_m[:2], PLACE_ENU_M, atol=0.3)


def test_the_gain_of_the_camera_changes_nothing() -> None:
    frames = [grey_levels(number, spot=50.0) for number in (1, 2, 3)]
    halved = [replace(frame, image=(frame.image.astype(np.uint16) * 200 + 3000)) for frame in frames]
    verdicts = [verdict_at(PersonWatch().look(seen, 0.0)) for seen in (frames, halved)]
    assert verdicts[0] == verdicts[1]


@pytest.mark.parametrize(
    "frames",
    [
        [grey_levels(1, spot=50.0), grey_levels(2, spot=50.0), grey_levels(3, spot=0.0)],
        [grey_levels(number, spot=21.0) for number in (1, 2, 3)],
        [grey_levels(number, spot=0.0) for number in (1, 2, 3)],
        [grey_levels(number, spot=-50.0) for number in (1, 2, 3)],
        [grey_levels(number, spot=50.0, place_enu_m=PLACE_ENU_M + 3.0 * number) for number in (1, 2, 3)],
    ],
    ids=["two frames", "faint", "nothing", "colder", "another place in each frame"],
)
def test_what_does_not_stand_out_of_grey_frames_is_no_find(frames: list[Frame]) -> None:
    verdict = verdict_at(PersonWatch().look(frames, 0.0))
    assert verdict is not None
    assert (verdict.kind, verdict.probability) == (FindingKind.OBJECT, None)


def test_warm_spots_all_about_are_no_find() -> None:
    def dotted(number: int) -> Frame:
        frame = grey_levels(number, spot=50.0)
        image = frame.image.copy()
        image[::7, ::7] = 255
        return replace(frame, image=image)

    verdict = verdict_at(PersonWatch().look([dotted(number) for number in (1, 2, 3)], 0.0))
    assert verdict is not None
    assert verdict.kind is FindingKind.OBJECT


def test_darker_spots_count_where_nobody_says_that_the_band_is_thermal() -> None:
    frames = [grey_levels(number, spot=-50.0, bands="grey") for number in (1, 2, 3)]
    verdict = verdict_at(PersonWatch().look(frames, 0.0))
    assert verdict is not None
    assert verdict.kind is FindingKind.ANOMALY


def test_frames_with_temperatures_decide_where_there_are_some_and_places_out_of_view_get_no_verdict() -> None:
    grey = [grey_levels(number, spot=50.0) for number in (4, 5, 6)]
    verdict = verdict_at(PersonWatch().look(grey, 0.0).look([person(1), person(2), person(3)], 0.0))
    assert verdict is not None
    assert verdict.kind is FindingKind.PERSON
    assert verdict_at(PersonWatch().look(grey, 0.0), PLACE_ENU_M + 500.0) is None


def test_vehicles_are_told_where_they_have_taken_several_frames() -> None:
    watch = PersonWatch()
    for _ in range(2):
        watch = watch.look([person(1), person(2)], 0.0)
    verdict = verdict_at(watch)
    assert verdict is not None
    assert "seen by 2 of 2 vehicles, in 4 of 4 frames" in verdict.reasons


def test_what_was_seen_is_forgotten_after_some_steps() -> None:
    cold = [replace(person(number), image=np.full((256, 256, 1), 11.0, np.float32)) for number in (1, 2)]
    watch = PersonWatch().look([person(1), person(2)], 0.0)
    for _ in range(KEPT_STEPS - 1):
        watch, judgements = watch_persons(watch, cold, 0.0, {7: PLACE_ENU_M}, Uncertainty())
        assert judgements[7].verdict.kind is FindingKind.PERSON
    verdict = verdict_at(watch.look(cold, 0.0))
    assert verdict is not None
    assert verdict.kind is FindingKind.OBJECT


def test_a_person_is_located_by_the_lines_of_all_steps() -> None:
    watch, sigmas_m2 = PersonWatch(), []
    for step in range(KEPT_STEPS + 3):
        # Another vehicle looks in every step.
        frames = [person(2 * step + 1), person(2 * step + 2)]
        watch, judgements = watch_persons(watch, frames, 0.0, {7: PLACE_ENU_M}, Uncertainty())
        assert judgements[7].views == ()
        place = judgements[7].place
        assert place is not None
        assert np.allclose(place.position_enu_m[:2], PLACE_ENU_M, atol=0.3)
        sigmas_m2.append(np.trace(place.covariance_m2[:2, :2]))
    assert sigmas_m2[-1] < 0.9 * sigmas_m2[KEPT_STEPS - 1]
    assert len(watch.lines[7].lines) == 2 * (KEPT_STEPS + 3)


def test_another_track_of_a_person_has_its_lines_of_sight() -> None:
    watch, _ = watch_persons(PersonWatch(), [person(1), person(2)], 0.0, {7: PLACE_ENU_M}, Uncertainty())
    places = {8: PLACE_ENU_M, 7: PLACE_ENU_M}
    watch, judgements = watch_persons(watch, [person(3), person(4)], 0.0, places, Uncertainty())
    assert watch.lines[7] is watch.lines[8]
    assert len(watch.lines[8].lines) == 4
    assert judgements[7].place is judgements[8].place


def test_what_is_left_keeps_its_lines_of_sight_but_not_what_was_seen() -> None:
    """A person who was watched, left and seen again was located by the few frames since."""
    watch, _ = watch_persons(PersonWatch(), [person(1), person(2)], 0.0, {7: PLACE_ENU_M}, Uncertainty())
    left = watch.without_steps()
    assert left.steps == ()
    again, _ = watch_persons(left, [person(3), person(4)], 0.0, {7: PLACE_ENU_M}, Uncertainty())
    assert [line.view.vehicle_id for line in again.lines[7].lines] == [1, 2, 3, 4]


def test_lines_to_what_is_no_person_yet_are_noted_for_the_time_when_it_is_taken_for_one() -> None:
    stones = [warm_frame(vehicle_id, clothes_k=5.0, skin_k=5.0, size_m=0.3) for vehicle_id in (1, 2, 3)]
    watch, judgements = watch_persons(PersonWatch(), stones, 0.0, {7: PLACE_ENU_M}, Uncertainty())
    assert judgements[7].verdict.kind is not FindingKind.PERSON
    assert [line.view.vehicle_id for line in watch.lines[7].lines] == [1, 2, 3]
    persons = [person(vehicle_id) for vehicle_id in (1, 2, 3)]
    watch, judgements = watch_persons(watch, persons, 0.0, {7: PLACE_ENU_M}, Uncertainty())
    assert judgements[7].verdict.kind is FindingKind.PERSON
    assert watch.lines[7].count == 6


def test_what_was_seen_before_is_moved_to_the_plane_of_the_latest_step() -> None:
    """Points of two planes, 2 m apart, are of one body only on one plane."""
    before = PersonWatch().look([person(1), person(2)], 20.0)
    watch = before.look([person(3)], 0.0)
    afresh = PersonWatch().look([person(1), person(2)], 0.0)
    for moved, seen in zip(watch.steps[0], afresh.steps[0], strict=True):
        np.testing.assert_allclose(moved.points_enu_m, seen.points_enu_m, atol=1e-9)
    assert before.on_plane(0.0).plane_height_m == watch.plane_height_m == 0.0


def test_what_may_be_a_person_is_suspected_wherever_it_is() -> None:
    """A person between leaves shows too little to be marked: nobody asked what was warm there."""
    watch, judgements = watch_persons(PersonWatch(), [person(1), person(2)], 0.0, {}, Uncertainty())
    assert judgements == {}
    assert watch.suspects_enu_m == (pytest.approx(tuple(PLACE_ENU_M), abs=0.3),)
    assert watch.without_steps().suspects_enu_m == ()


def test_neither_a_lukewarm_stone_nor_what_one_vehicle_sees_is_suspected() -> None:
    stones = [warm_frame(vehicle_id, clothes_k=5.0, skin_k=5.0, size_m=0.3) for vehicle_id in (1, 2, 3)]
    for frames in (stones, [person(1)]):
        watch, _ = watch_persons(PersonWatch(), frames, 0.0, {}, Uncertainty())
        assert watch.suspects_enu_m == ()


def test_in_flight_a_body_that_may_be_warmer_than_it_looks_is_suspected() -> None:
    def smeared(clothes_k: float, skin_k: float, *, warmer_k: float = 0.0) -> PersonWatch:
        bodies = [warm_frame(one, clothes_k=clothes_k, skin_k=skin_k) for one in (1, 2)]
        frames = [replace(one, image=one.image + np.float32(warmer_k), speed_mps=5.0) for one in bodies]
        return watch_persons(PersonWatch(), frames, 0.0, {}, Uncertainty())[0]

    assert len(smeared(7.0, 13.0).suspects_enu_m) == 1
    assert smeared(5.0, 6.0).suspects_enu_m == ()
    assert len(smeared(5.0, 6.0, warmer_k=7.0).suspects_enu_m) == 1, "skin stands out less of a warmer forest"
