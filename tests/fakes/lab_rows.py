"""Rows of runs that nobody has flown, for what is computed of rows."""

from dataclasses import replace

import numpy as np
import pyarrow as pa

from aos_gcs.lab.rows import StepRow
from aos_gcs.lab.tables import to_table

TIMES_S = np.linspace(0.0, 20.0, 41)
ROW = StepRow(
    initialisation="",
    strategy="",
    step=1,
    time_s=0.0,
    visibility=0.0,
    area_m2=0.0,
    unoccluded_m2=1.0,
    history_visibility=0.0,
    history_area_m2=0.0,
    in_view=True,
    branch="pso",
    leader_id=1,
    evolutionary_factor=0.5,
    evolutionary_state=None,
    c_s_m=None,
    c_c_m=None,
    east_m=[0.0, 4.0],
    north_m=[0.0, 0.0],
    height_m=[35.0, 36.0],
    fitness=[0.0, 0.0],
    target_east_m=0.0,
    target_north_m=0.0,
    target_error_m=0.1,
    min_distance_m=4.0,
    min_flight_distance_m=4.0,
    path_m=0.0,
)


def run_at(level: float, strategy: str, initialisation: str) -> pa.Table:
    """Return a run whose V, A and history stay at one level."""
    values = {"visibility": level, "area_m2": level, "history_visibility": level}
    named = replace(ROW, strategy=strategy, initialisation=initialisation, **values)
    return to_table(replace(named, step=step, time_s=float(t)) for step, t in enumerate(TIMES_S, start=1))
