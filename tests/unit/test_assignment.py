import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps
from scipy.optimize import linear_sum_assignment

from aos_gcs.assignment import least_cost_columns

shapes = st.tuples(st.integers(1, 7), st.integers(1, 7))


@given(nps.arrays(np.float64, shapes, elements=st.integers(-4, 4) | st.floats(-100.0, 100.0)))
def test_the_costs_are_the_least_and_no_column_is_given_twice(costs: np.ndarray) -> None:
    columns = least_cost_columns(costs)
    rows = np.flatnonzero(columns >= 0)
    assert len(rows) == min(costs.shape)
    assert len(set(columns[rows].tolist())) == len(rows)
    assert costs[rows, columns[rows]].sum() == pytest.approx(costs[linear_sum_assignment(costs)].sum(), abs=1e-9)


def test_rows_without_a_column_have_none() -> None:
    assert least_cost_columns([[3.0], [1.0], [2.0]]).tolist() == [-1, 0, -1]
    assert least_cost_columns([[3.0, 1.0, 2.0]]).tolist() == [1]
    assert least_cost_columns(np.empty((2, 0))).tolist() == [-1, -1]


def test_equal_costs_leave_everything_where_it_is() -> None:
    assert least_cost_columns(np.ones((4, 4))).tolist() == [0, 1, 2, 3]
