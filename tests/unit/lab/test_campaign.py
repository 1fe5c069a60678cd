"""Campaigns: their folders, going on after an interruption, and what is refused."""

import dataclasses
import json
import logging
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pytest

from aos_gcs.cluster import MAX_JOBS
from aos_gcs.errors import AosError, ConfigurationError, InputDataError, LinkError
from aos_gcs.lab import workers
from aos_gcs.lab.campaign import Campaign, run_initialisation
from aos_gcs.lab.initialisation import Initialisation, draw_initialisations
from aos_gcs.lab.results import MANIFEST, STEPS, ResultFolder, create_results, open_results
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.strategies import parse_strategies
from aos_gcs.lab.tables import SCHEMA

pytestmark = pytest.mark.realtime

SMALL = Scenario(forest_side_m=40.0, trees_per_ha=100.0, drones=3, duration_s=1.0, start_distance_m=12.0)

LARGER = dataclasses.replace(SMALL, forest_side_m=50.0)


def campaign(count: int = 3, strategies: str = "aos-pso,aos-apso(gamma=0.8)", scenario: Scenario = SMALL) -> Campaign:
    return Campaign(scenario, parse_strategies(strategies), draw_initialisations(count, 0, scenario))


def compute(results: ResultFolder, jobs: int = 1) -> None:
    workers.compute(results, lambda _: None, jobs=jobs)


@pytest.fixture(scope="module")
def expected() -> pa.Table:
    wanted = campaign()
    return pa.concat_tables([run_initialisation(wanted, start) for start in wanted.initialisations])


def test_the_folder_holds_a_row_per_step_of_every_run(tmp_path: Path, expected: pa.Table) -> None:
    compute(create_results(tmp_path / "a", campaign()))
    stored = open_results(tmp_path / "a")
    assert stored.campaign == campaign()
    assert stored.missing() == ()
    table = stored.read()
    assert table.schema == SCHEMA
    assert table.equals(expected)
    runs = {
        (row["initialisation"], row["strategy"]) for row in table.select(["initialisation", "strategy"]).to_pylist()
    }
    assert len(runs) == 6


def test_an_interrupted_campaign_goes_on_without_computing_twice(
    tmp_path: Path, expected: pa.Table, monkeypatch: pytest.MonkeyPatch
) -> None:
    computed = []

    def counted(wanted: Campaign, start: Initialisation) -> pa.Table:
        computed.append(start.name)
        if len(computed) == 2:
            raise KeyboardInterrupt
        return run_initialisation(wanted, start)

    monkeypatch.setattr(workers, "run_initialisation", counted)
    with pytest.raises(KeyboardInterrupt):
        compute(create_results(tmp_path / "a", campaign()))
    assert len(open_results(tmp_path / "a").missing()) == 2
    compute(create_results(tmp_path / "a", campaign()))
    assert computed == ["00000", "00001", "00001", "00002"]
    assert open_results(tmp_path / "a").read().equals(expected)


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_workers(tmp_path: Path, expected: pa.Table) -> None:
    for jobs in (1, 2):
        results = create_results(tmp_path / str(jobs), campaign())
        compute(results, jobs=jobs)
        assert results.read().equals(expected)


@pytest.mark.slow
def test_a_scheduler_elsewhere_gives_the_same_results(tmp_path: Path, expected: pa.Table) -> None:
    from distributed import LocalCluster  # noqa: PLC0415 - takes a second

    results = create_results(tmp_path, campaign())
    with LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=logging.ERROR
    ) as cluster:
        workers.compute(results, lambda _: None, scheduler=cluster.scheduler_address)
    assert results.read().equals(expected)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (lambda: campaign(2), "initialisations differ"),
        (lambda: campaign(strategies="aos-pso"), "strategies differ"),
        (lambda: campaign(scenario=LARGER), "forest_side_m is 40.0 there and 50.0 here"),
    ],
)
def test_a_folder_of_another_campaign_is_refused(tmp_path: Path, other: Callable[[], Campaign], words: str) -> None:
    create_results(tmp_path, campaign())
    with pytest.raises(ConfigurationError, match=words) as caught:
        create_results(tmp_path, other())
    assert "Choose another --out" in str(caught.value)


def test_a_folder_that_was_cut_off_at_its_beginning_is_begun_again(tmp_path: Path) -> None:
    (tmp_path / STEPS).mkdir()
    (tmp_path / STEPS / f"{MANIFEST}.tmp").write_text("{")
    assert len(create_results(tmp_path, campaign()).missing()) == 3


def _foreign(folder: Path) -> None:
    (folder / "thesis.tex").write_text("")


def _without_manifest(folder: Path) -> None:
    (create_results(folder, campaign()).folder / MANIFEST).unlink()
    (folder / STEPS / "00000.parquet").write_bytes(b"PAR1")


def _with_half_a_manifest(folder: Path) -> None:
    path = create_results(folder, campaign()).folder / MANIFEST
    path.write_text(path.read_text()[:100])


def _with_a_damaged_file(folder: Path) -> None:
    create_results(folder, campaign())
    (folder / STEPS / "00001.parquet").write_bytes(b"PAR1 and no more")


def _with_a_file_of_another_campaign(folder: Path) -> None:
    other = ResultFolder(folder, campaign(scenario=LARGER))
    create_results(folder, campaign())
    other.write(campaign().initialisations[0], SCHEMA.empty_table())


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (_foreign, "has no campaign.json"),
        (_without_manifest, "has no campaign.json"),
        (_with_half_a_manifest, "campaign.json cannot be read"),
        (_with_a_damaged_file, "00001.parquet is damaged .*; delete it and run the campaign again"),
        (_with_a_file_of_another_campaign, "00000.parquet belongs to another campaign"),
    ],
)
def test_spoilt_folders_are_refused_with_a_remedy(tmp_path: Path, spoil: Callable[[Path], None], words: str) -> None:
    spoil(tmp_path)
    with pytest.raises(AosError, match=words):
        compute(create_results(tmp_path, campaign()))


@pytest.mark.parametrize(
    ("manifest", "words"),
    [
        ({"format": 99}, "has format 99"),
        ({"format": 1}, "is not the manifest of a campaign"),
        ([], "is not the manifest"),
    ],
)
def test_manifests_of_others_are_refused(tmp_path: Path, manifest: object, words: str) -> None:
    (tmp_path / MANIFEST).write_text(json.dumps(manifest))
    with pytest.raises(InputDataError, match=words):
        open_results(tmp_path)


def test_a_folder_without_a_campaign_has_no_results(tmp_path: Path) -> None:
    with pytest.raises(InputDataError, match=r"it has no campaign\.json"):
        open_results(tmp_path)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nowhere:nothing:at-all"])
def test_an_unreachable_scheduler_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    monkeypatch.setattr("aos_gcs.cluster.CONNECT_TIMEOUT_S", 0.3)
    with pytest.raises(LinkError, match=f"scheduler {address} cannot be reached"):
        workers.compute(create_results(tmp_path, campaign()), lambda _: None, scheduler=address)


@pytest.mark.parametrize("jobs", [0, MAX_JOBS + 1])
def test_the_number_of_jobs_has_bounds(tmp_path: Path, jobs: int) -> None:
    with pytest.raises(ConfigurationError, match=f"--jobs must lie within 1 and {MAX_JOBS}, two per core"):
        compute(create_results(tmp_path, campaign()), jobs=jobs)
