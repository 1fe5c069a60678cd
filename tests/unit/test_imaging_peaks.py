import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from aos_gcs.imaging.focus.peaks import Peak, peaks_of

values = st.lists(st.integers(0, 4) | st.floats(0.0, 4.0, width=32), min_size=1, max_size=25)


def by_scipy(curve: np.ndarray) -> list[tuple[float, ...]]:
    # Seconds to import, which only the process that runs this test should pay.
    from scipy.signal import find_peaks, peak_prominences, peak_widths  # noqa: PLC0415

    indices = find_peaks(curve)[0]
    prominences = peak_prominences(curve, indices)
    widths = peak_widths(curve, indices, 0.5, prominences)[0]
    return list(zip(indices.tolist(), prominences[0].tolist(), widths.tolist(), strict=True))


@given(values)
@example([0.0, 2.0, 2.0, 0.0, 1.0, 0.0])
@example([0.0, 1.0, 3.0, 2.0, 2.0, 2.5, 1.0])
def test_peaks_are_those_of_scipy(numbers: list[float]) -> None:
    curve = np.array(numbers, dtype=np.float64)
    found = [(peak.index, peak.prominence, peak.width) for peak in peaks_of(curve)]
    np.testing.assert_allclose(np.array(found).reshape(-1, 3), np.array(by_scipy(curve)).reshape(-1, 3), atol=1e-9)


def test_a_tent_is_as_wide_as_half_of_its_height() -> None:
    assert peaks_of(np.array([0.0, 1.0, 2.0, 1.0, 0.0])) == [Peak(2, 2.0, 2.0)]
