"""Reports made of rows: known numbers must come out, and incomplete campaigns must not mislead."""

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.lab.bound import ORACLE
from aos_gcs.lab.report import Comparison, compare, difference_table, summary_table, write_report
from aos_gcs.lab.rows import StepRow
from aos_gcs.lab.runs import split_runs
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.tables import to_table

SCENARIO = Scenario(drones=2)
STEP_S = 0.4
HEIGHTS_M = [35.0, 36.0]


def rows(strategy: str, initialisation: str, level: float, first_seen_s: float = 2.0) -> Iterator[StepRow]:
    """A run whose visibility is ``level`` from ``first_seen_s`` on, with drones that walk east together."""
    for step in range(1, 52):
        time_s = (step - 1) * STEP_S
        seen = time_s >= first_seen_s
        yield StepRow(
            initialisation=initialisation,
            strategy=strategy,
            step=step,
            time_s=time_s,
            visibility=level if seen else 0.0,
            area_m2=0.5 * level if seen else 0.0,
            unoccluded_m2=0.5,
            history_visibility=level if seen else 0.0,
            history_area_m2=0.5 * level if seen else 0.0,
            in_view=seen,
            branch="pso" if seen else "line",
            leader_id=2 if seen else None,
            evolutionary_factor=0.25 if seen else None,
            evolutionary_state="exploration" if seen else None,
            c_s_m=2.0,
            c_c_m=1.0,
            east_m=[float(step), float(step)],
            north_m=[0.0, 4.0],
            height_m=HEIGHTS_M,
            fitness=[0.1, 0.2],
            target_east_m=10.0,
            target_north_m=2.0,
            target_error_m=0.3 if seen else None,
            min_distance_m=4.0,
            min_flight_distance_m=4.0,
            path_m=float(step - 1),
        )


def table(levels: dict[tuple[str, str], float]) -> pa.Table:
    runs = [rows(*run, level, first_seen_s=0.0 if run[0] == ORACLE else 2.0) for run, level in levels.items()]
    return pa.concat_tables([to_table(run) for run in runs])


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    base = {"a": 0.3, "b": 0.5, "c": 0.7}
    levels = {("old", name): level for name, level in base.items()}
    levels |= {("new", name): level + 0.1 for name, level in base.items()}
    levels |= {(ORACLE, name): 1.0 for name in base}
    return compare(SCENARIO, ["old", "new"], table(levels))


def test_numbers_of_a_run(comparison: Comparison) -> None:
    (run,) = (run for run in comparison.of("new") if run.initialisation == "b")
    metrics = run.metrics(SCENARIO.duration_s)
    assert metrics.visibility_mean == pytest.approx(0.6)
    assert metrics.area_mean_m2 == pytest.approx(0.3)
    assert metrics.detection_s == pytest.approx(2.0)
    assert metrics.path_m == 50.0
    assert metrics.min_distance_m == 4.0
    assert metrics.position_error_m == pytest.approx(0.3)


def test_curves_are_interpolated_between_steps(comparison: Comparison) -> None:
    curve = comparison.curves("visibility")["old"][0]
    at = np.searchsorted(comparison.times_s, 1.75)
    assert curve[at] == pytest.approx(0.3 * (1.75 - 1.6) / STEP_S)  # between the last blind and the first seeing step


def test_trace_names_the_leader_by_row(comparison: Comparison) -> None:
    trace = comparison.of("old")[0].trace()
    assert trace.positions_enu_m.shape == (51, 2, 2)
    assert trace.leader[0] is None
    assert trace.leader[-1] == 1


def test_pairs_cancel_what_initialisations_have_in_common(comparison: Comparison) -> None:
    (difference,) = comparison.against("old", "visibility_mean")
    assert difference.difference.mean == pytest.approx(0.1)
    assert difference.difference.half_width < 1e-6
    assert "+0.100 (+0.100 to +0.100)" in difference_table(comparison, "old")


def test_summary_compares_with_the_oracle(comparison: Comparison) -> None:
    new = next(line for line in summary_table(comparison).splitlines() if line.startswith("| new"))
    assert "| 0.60 |" in new  # share of the oracle's 1.0
    assert "100 %, 2.0 s" in new


def test_initialisations_that_some_strategy_lacks_are_left_out() -> None:
    partial = compare(SCENARIO, ["old", "new"], table({("old", "a"): 0.2, ("new", "a"): 0.3, ("old", "b"): 0.9}))
    assert partial.initialisations == ("a",)
    assert partial.oracle("visibility") is None


def test_nothing_complete_is_an_error() -> None:
    with pytest.raises(InputDataError, match="no initialisation has been finished"):
        compare(SCENARIO, ["old", "new"], table({("old", "a"): 0.2, ("new", "b"): 0.3}))


def test_runs_come_back_whole_whatever_the_order_of_rows() -> None:
    ordered = table({("old", "a"): 0.2, ("new", "a"): 0.3})
    shuffled = ordered.take(np.random.default_rng(0).permutation(len(ordered)))
    runs = list(split_runs(shuffled))
    assert [(run.strategy, len(run.table)) for run in runs] == [("new", 51), ("old", 51)]
    assert all((np.diff(run.column("time_s")) > 0).all() for run in runs)


def test_unknown_reference_is_refused_before_anything_is_written(comparison: Comparison, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="choose one of old, new"):
        write_report(comparison, tmp_path / "report", reference="other", shown_runs=0)
    assert not (tmp_path / "report").exists()


@pytest.mark.slow
def test_report_has_all_its_files(comparison: Comparison, tmp_path: Path) -> None:
    path = write_report(comparison, tmp_path / "report", reference="old", shown_runs=1)
    text = path.read_text(encoding="utf-8")
    named = [line.split("](")[1].rstrip(")") for line in text.splitlines() if line.startswith("![")]
    assert len(named) == len(set(named)) == 16
    for name in named:
        assert (path.parent / name).read_bytes().startswith(b"\x89PNG")
        assert (path.parent / name).with_suffix(".svg").exists()
    with (path.parent / "runs.csv").open(encoding="utf-8", newline="") as file:
        numbers = list(csv.DictReader(file))
    assert [float(row["visibility_mean"]) for row in numbers] == pytest.approx([0.3, 0.5, 0.7, 0.4, 0.6, 0.8])
