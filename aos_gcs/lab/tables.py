"""Tables of the laboratory's results, as they are written in Parquet.

Apart from the rows: simulated missions fly without the library that tables need.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields

import pyarrow as pa

from aos_gcs.lab.rows import StepRow

SCHEMA = pa.schema(
    [
        pa.field("initialisation", pa.string(), nullable=False),
        pa.field("strategy", pa.string(), nullable=False),
        pa.field("step", pa.int32(), nullable=False),
        pa.field("time_s", pa.float64(), nullable=False),
        pa.field("visibility", pa.float64(), nullable=False),
        pa.field("area_m2", pa.float64(), nullable=False),
        pa.field("unoccluded_m2", pa.float64(), nullable=False),
        pa.field("history_visibility", pa.float64(), nullable=False),
        pa.field("history_area_m2", pa.float64(), nullable=False),
        pa.field("in_view", pa.bool_(), nullable=False),
        pa.field("branch", pa.string(), nullable=False),
        pa.field("leader_id", pa.int32()),
        pa.field("evolutionary_factor", pa.float64()),
        pa.field("evolutionary_state", pa.string()),
        pa.field("c_s_m", pa.float64()),
        pa.field("c_c_m", pa.float64()),
        pa.field("east_m", pa.list_(pa.float64()), nullable=False),
        pa.field("north_m", pa.list_(pa.float64()), nullable=False),
        pa.field("height_m", pa.list_(pa.float64()), nullable=False),
        pa.field("fitness", pa.list_(pa.float64()), nullable=False),
        pa.field("target_east_m", pa.float64(), nullable=False),
        pa.field("target_north_m", pa.float64(), nullable=False),
        pa.field("target_error_m", pa.float64()),
        pa.field("min_distance_m", pa.float64(), nullable=False),
        pa.field("min_flight_distance_m", pa.float64(), nullable=False),
        pa.field("path_m", pa.float64(), nullable=False),
    ]
)
"""The columns of the result files; those of :class:`~aos_gcs.lab.rows.StepRow`, in its order."""


def to_table(rows: Iterable[StepRow]) -> pa.Table:
    """Return the rows as a table of :data:`SCHEMA`."""
    listed = list(rows)
    columns = {item.name: [getattr(row, item.name) for row in listed] for item in fields(StepRow)}
    return pa.table(columns, schema=SCHEMA)
