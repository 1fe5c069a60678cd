"""Peaks of a curve, compared with SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.imaging.focus.peaks import curve_peaks


@given(st.lists(st.integers(-4, 4) | st.floats(-4.0, 4.0), max_size=40))
def test_peaks_are_those_of_scipy(values: list[float]) -> None:
    curve = np.array(values, dtype=np.float64)
    indices = scipy.signal.find_peaks(curve)[0]
    peaks = curve_peaks(values)
    assert [peak.index for peak in peaks] == indices.tolist()
    assert [peak.prominence for peak in peaks] == pytest.approx(
        scipy.signal.peak_prominences(curve, indices)[0].tolist()
    )
    assert [peak.width for peak in peaks] == pytest.approx(scipy.signal.peak_widths(curve, indices, 0.5)[0].tolist())


def test_the_middle_of_a_plateau_counts_and_ends_of_the_curve_do_not() -> None:
    assert [peak.index for peak in curve_peaks([5.0, 1.0, 3.0, 3.0, 3.0, 0.0, 2.0, 2.0])] == [3]
