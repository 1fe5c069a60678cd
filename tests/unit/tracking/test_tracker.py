"""Tracks of simulated targets: consistency, several targets, false alarms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import chdtri

from aos_gcs.errors import ConfigurationError
from aos_gcs.tracking.motion import MotionSettings, begin, density, predict
from aos_gcs.tracking.tracker import Measurement, TrackingSettings, Tracks, observe

SETTINGS = TrackingSettings()
RUNS = 30


def everywhere(_: np.ndarray) -> bool:
    return True


def seen(position: np.ndarray, sigma_m: float = 0.4, bias_m: float = 0.0) -> Measurement:
    return Measurement(np.asarray(position, float), sigma_m**2 * np.eye(2), bias_m**2 * np.eye(2))


def follow(path: np.ndarray, rng: np.random.Generator, step_s: float, sigma_m: float, bias_m: float) -> list[float]:
    """Return the error of the first track at each step, normalised by its covariance."""
    tracks, bias = Tracks(), rng.normal(0.0, bias_m, 2)
    normalised = []
    for step, position in enumerate(path):
        measurement = seen(position + bias + rng.normal(0.0, sigma_m, 2), sigma_m, bias_m)
        tracks, ids = observe(tracks, [measurement], step * step_s, SETTINGS, everywhere)
        assert ids == (1,), "the target has left its track"
        track = tracks.tracks[0]
        error_m = track.position_enu_m - position
        normalised.append(float(error_m @ np.linalg.solve(track.covariance_m2, error_m)))
    return normalised


def walk(rng: np.random.Generator, speed_mps: float, steps: int, step_s: float) -> np.ndarray:
    """A path whose velocity is disturbed by the white acceleration that the tracker assumes."""
    density = SETTINGS.motion.acceleration_m2ps3 if speed_mps else 0.0
    heading = rng.uniform(0.0, 2 * np.pi)
    position, velocity = rng.uniform(-5, 5, 2), speed_mps * np.array([np.cos(heading), np.sin(heading)])
    path, fine = [], 20
    for _ in range(steps):
        path.append(position)
        for _ in range(fine):
            position = position + velocity * step_s / fine
            velocity = velocity + rng.normal(0.0, np.sqrt(density * step_s / fine), 2)
    return np.array(path)


@pytest.mark.parametrize("step_s", [1.0, 4.0])
@pytest.mark.parametrize("speed_mps", [0.0, 1.5, 4.0])
def test_errors_are_as_large_as_the_covariance_says(speed_mps: float, step_s: float) -> None:
    rng = np.random.default_rng(3)
    errors = np.array([follow(walk(rng, speed_mps, 12, step_s), rng, step_s, 0.4, 0.0) for _ in range(RUNS)])
    low, high = chdtri(2 * RUNS, [0.999, 0.001]) / RUNS
    for step in (0, 1, 4, 8, 11):
        assert low < errors[:, step].mean() < high


def test_biases_do_not_average_out() -> None:
    rng = np.random.default_rng(5)
    errors = np.array([follow(np.zeros((25, 2)), rng, 2.0, 0.2, 0.6) for _ in range(RUNS)])
    low, high = chdtri(2 * RUNS, [0.999, 0.001]) / RUNS
    assert low < errors[:, -1].mean() < high


def run(steps: list[list[tuple[float, float]]], step_s: float = 2.0) -> tuple[Tracks, list[tuple[int, ...]]]:
    tracks, ids = Tracks(), []
    for step, positions in enumerate(steps):
        tracks, own = observe(tracks, [seen(p) for p in positions], step * step_s, SETTINGS, everywhere)
        ids.append(own)
    return tracks, ids


def test_a_still_target_is_averaged_and_a_walker_followed() -> None:
    still, _ = run([[(3.0, 1.0)]] * 20)
    (track,) = still.tracks
    assert track.walking_share < 0.1
    assert np.sqrt(track.covariance_m2[0, 0]) < 0.16
    walking, _ = run([[(3.0 * step, -1.0)] for step in range(10)])
    (track,) = walking.tracks
    assert track.walking_share > 0.9
    np.testing.assert_allclose(track.velocity_enu_mps, [1.5, 0.0], atol=0.1)


def test_who_stops_and_sets_out_again_is_followed() -> None:
    east_m = np.cumsum([0.0] * 10 + [3.0] * 10 + [0.0] * 10)
    tracks, ids = run([[(float(east), 0.0)] for east in east_m])
    assert set(ids) == {(1,)}
    np.testing.assert_allclose(tracks.tracks[0].position_enu_m, [30.0, 0.0], atol=0.3)
    assert tracks.tracks[0].walking_share < 0.5


def test_two_targets_that_cross_keep_their_ids() -> None:
    rng = np.random.default_rng(2)
    steps = []
    for t in np.arange(0.0, 16.0, 1.0):
        places = np.array([(-12.0 + 1.5 * t, 0.4 * t - 3.2), (12.0 - 1.5 * t, 3.2 - 0.4 * t)])
        places[:, 1] += [1.0, -1.0]
        steps.append([tuple(place) for place in places + rng.normal(0.0, 0.3, (2, 2))])
    _, ids = run(steps, step_s=1.0)
    assert set(ids) == {(1, 2)}


def test_measurements_may_come_in_any_order() -> None:
    there = [(0.0, 0.0), (6.0, 0.0)]
    _, ids = run([there, there, there[::-1], there])
    assert ids == [(1, 2), (1, 2), (2, 1), (1, 2)]


def test_a_track_is_confirmed_by_four_of_six() -> None:
    here: list[tuple[float, float]] = [(1.0, 1.0)]
    confirmed = [run([here, [], here, [], here, here][:n])[0].tracks[0].confirmed for n in range(1, 7)]
    assert confirmed == [False] * 5 + [True]
    assert run([here, [], here, [], []])[0].tracks == ()


def test_false_alarms_are_not_confirmed() -> None:
    """One false alarm in every second step, anywhere in the view of a swarm, for 400 steps."""
    rng, tracks = np.random.default_rng(8), Tracks()
    for step in range(400):
        alarms = rng.uniform(-30.0, 30.0, (int(rng.random() < 0.5), 2))
        tracks, _ = observe(tracks, [seen(place) for place in alarms], 2.0 * step, SETTINGS, everywhere)
        assert not any(track.confirmed for track in tracks.tracks)


def test_only_steps_that_look_count_as_misses() -> None:
    tracks, _ = run([[(0.0, 0.0)]] * 4)
    elsewhere = looked = tracks
    for step in range(4, 30):
        elsewhere, _ = observe(elsewhere, [], 2.0 * step, SETTINGS, lambda _: False)
        looked, _ = observe(looked, [], 2.0 * step, SETTINGS, everywhere)
    assert elsewhere.find(1) is not None
    assert observe(elsewhere, [], 500.0, SETTINGS, lambda _: False)[0].tracks == ()
    assert looked.find(1) is None


def test_time_does_not_run_backwards() -> None:
    motion = begin(np.zeros(2), np.eye(2), 10.0, MotionSettings())
    assert predict(motion, 9.0, MotionSettings()) is motion


@pytest.mark.parametrize("wrong", [{"new_per_m2": 0.0}, {"confirm_hits": 7}, {"forget_s": float("nan")}])
def test_settings_out_of_range_are_refused_by_name(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        TrackingSettings(**wrong)  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="still_s"):
        MotionSettings(still_s=0.0)


def test_a_track_that_was_not_seen_for_long_does_not_take_what_is_seen_elsewhere() -> None:
    tracks, _ = run([[(0.0, 0.0)]] * 6)
    tracks, ids = observe(tracks, [seen([25.0, 2.0])], 90.0, SETTINGS, lambda _: False)
    assert ids == (2,)
    tracks, ids = observe(tracks, [seen([1.0, 0.0])], 91.0, SETTINGS, lambda _: False)
    assert ids == (1,)


def test_a_target_that_has_stayed_is_not_elsewhere_when_something_else_comes_into_view() -> None:
    """A second track of a person went over to a stone beyond reach, and the stone counted as a person from then on."""
    stays, elsewhere = [(0.0, 0.0)], [(0.0, 6.0)]
    _, ids = run([*[stays] * 5, elsewhere, stays], step_s=4.0)
    assert ids == [*[(1,)] * 5, (2,), (1,)]


def test_a_target_seen_twice_in_one_place_does_not_go_over_to_another_body() -> None:
    """The track of a stone, not confirmed yet, went over to a person 9 m away and on at 2 m/s to where nobody was."""
    stays, elsewhere = [(0.0, 0.0)], [(0.0, 9.0)]
    _, ids = run([stays, stays, elsewhere], step_s=4.0)
    assert ids == [(1,), (1,), (2,)]


def test_pairs_that_are_too_far_apart_are_not_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    weighed = []

    def counted(*arguments: object) -> float:
        weighed.append(arguments)
        return density(*arguments)

    places_m = [np.array([40.0 * number, 0.0]) for number in range(5)]
    tracks = Tracks()
    for now_s in (0.0, 1.0, 2.0):
        tracks, ids = observe(tracks, [seen(place_m) for place_m in places_m], now_s, SETTINGS, everywhere)
    monkeypatch.setattr("aos_gcs.tracking.tracker.density", counted)
    tracks, ids = observe(tracks, [seen(place_m) for place_m in places_m], 3.0, SETTINGS, everywhere)
    assert ids == (1, 2, 3, 4, 5)
    assert len(weighed) == len(places_m)
