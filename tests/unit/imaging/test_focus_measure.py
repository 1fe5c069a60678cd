import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aos_gcs.imaging.focus.measure import MAX_GROUPS, Agreement, CameraGroups, FocusSignal, focus_signal


def agreement_of(*frames: np.ndarray) -> Agreement:
    total = Agreement(*frames[0].shape, groups=len(frames))
    for index, frame in enumerate(frames):
        total.add(frame.astype(np.float32), index)
    return total


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), frames=st.integers(2, 6), channels=st.integers(1, 4))
def test_it_is_the_mean_correlation_of_all_pairs(seed: int, frames: int, channels: int) -> None:
    rng = np.random.default_rng(seed)
    common = rng.normal(size=(300, channels))
    stack = np.stack([common + rng.normal(size=common.shape) for _ in range(frames)]).astype(np.float32)
    products = np.einsum("ipc,jpc->ijc", stack, stack, dtype=np.float64)
    pairs = products[~np.eye(frames, dtype=bool)].mean(axis=0)
    variances = np.einsum("iic->ic", products).mean(axis=0)
    assert agreement_of(*stack).value() == pytest.approx(np.mean(pairs / variances), abs=1e-5)


def test_equal_frames_agree_fully_whatever_their_units() -> None:
    frame = np.random.default_rng(0).normal(size=(200, 2)) * [1e-3, 1e3]
    assert agreement_of(frame, frame, frame).value() == pytest.approx(1.0, abs=1e-5)


def test_frames_that_share_nothing_scatter_about_zero_as_predicted() -> None:
    rng = np.random.default_rng(1)
    totals = [agreement_of(*rng.normal(size=(5, 400, 1))) for _ in range(200)]
    values = [total.value() for total in totals]
    assert abs(np.mean(values)) < 0.002
    assert np.std(values) == pytest.approx(totals[0].scatter(1.0), rel=0.15)


def test_only_points_that_two_frames_cover_count() -> None:
    rng = np.random.default_rng(2)
    common = rng.normal(size=(400, 1))
    left, right = common.copy(), common.copy()
    left[300:] = np.nan
    right[:100] = np.nan
    assert agreement_of(left, right).value() == pytest.approx(1.0, abs=0.15)
    left[100:] = np.nan
    apart = agreement_of(left, right)
    assert apart.value() == 0.0
    assert apart.scatter(1.0) == np.inf


def test_frames_without_structure_agree_on_nothing() -> None:
    signal = focus_signal(np.full((20, 30, 3), 7, dtype=np.uint8), FocusSignal.TEXTURE)
    samples = signal.reshape(-1, 3)
    assert agreement_of(samples, samples).value() == 0.0


def test_the_signal_leaves_out_what_says_little_about_height() -> None:
    u = np.arange(200)
    waves = [np.tile(np.sin(2 * np.pi * u / length), (40, 1))[:, :, np.newaxis] for length in (2.5, 15.0, 190.0)]
    passed = [focus_signal(wave.astype(np.float32), FocusSignal.TEXTURE)[:, 40:-40].std() for wave in waves]
    assert passed[1] > 0.6
    assert passed[0] < 0.1
    assert passed[2] < 0.1


@pytest.mark.parametrize("signal", list(FocusSignal))
def test_pixels_that_are_not_finite_take_no_part(signal: FocusSignal) -> None:
    image = np.random.default_rng(3).normal(size=(31, 40, 2)).astype(np.float32)
    image[10, 12, 1] = np.nan
    filtered = focus_signal(image, signal, reduction=2)
    assert filtered.shape == (16, 20, 1 if signal is FocusSignal.ANOMALY else 2)
    unknown = np.isnan(filtered).any(axis=2)
    assert unknown[5, 6]
    assert unknown.sum() <= 4


def test_the_anomaly_signal_sees_warm_spots_and_no_texture() -> None:
    rng = np.random.default_rng(4)
    image = rng.normal(10.0, 0.1, size=(60, 60, 1)).astype(np.float32)
    image[30:32, 20:24] = 30.0
    filtered = focus_signal(image, FocusSignal.ANOMALY)[:, :, 0]
    assert filtered[30:32, 20:22].min() > 0.2
    assert np.abs(filtered[:, 44:]).max() < 0.01


def test_cameras_close_together_are_one_group() -> None:
    groups = CameraGroups(4.0)
    assert [groups.add(np.array([x, 0.0, 30.0])) for x in (0.0, 1.0, 5.0, 3.0, 9.5, 0.5)] == [0, 0, 1, 1, 2, 0]


def test_there_are_no_more_groups_than_room() -> None:
    groups = CameraGroups(0.0)
    indices = [groups.add(np.array([float(x), 0.0, 0.0])) for x in range(2 * MAX_GROUPS)]
    assert indices == [*range(MAX_GROUPS), *[MAX_GROUPS - 1] * MAX_GROUPS]


def test_frames_of_one_group_are_not_compared() -> None:
    rng = np.random.default_rng(0)
    crown, other = rng.normal(size=(2, 4000, 1)).astype(np.float32)
    total = Agreement(4000, 1, groups=2)
    for samples, group in ((crown, 0), (crown, 0), (other, 1)):
        total.add(samples, group)
    assert abs(total.value()) < 0.1
    assert total.scatter(1.0) == pytest.approx(np.sqrt(2.0 / (4 * 4000)))
