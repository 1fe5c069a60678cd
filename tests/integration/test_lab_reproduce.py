"""``aos-gcs lab reproduce``: document, figures and going on, of runs that nobody has flown."""

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pytest

from aos_gcs.cli.lab import reproduce as command
from aos_gcs.lab import document, report, studies, workers
from aos_gcs.lab.bound import ORACLE
from aos_gcs.lab.document import BEGIN_MARK, END_MARK, FIGURES
from aos_gcs.lab.results import ResultFolder
from aos_gcs.lab.studies import BETTER, STUDIES
from tests.fakes.command_line import exit_status
from tests.fakes.lab_rows import run_at

NEEDED = ("integral", "static-300", "static-400", "static-500", "walking-1.5", "walking-4")
"""Studies that the tables of claims and goals are made of."""
EVERY = tuple(study.name for study in STUDIES)


def write_runs(results: ResultFolder, advance: Callable[[int], None], **_options: object) -> None:
    """Stand in for hours of computing: every initialisation is a little better than the one before."""
    labels = [choice.label for choice in results.campaign.strategies]
    if results.campaign.oracle:
        labels.append(ORACLE)
    for number, initialisation in enumerate(results.missing()):
        levels = {label: 0.3 + 0.01 * number + 0.3 * (label == BETTER) for label in labels}
        results.write(
            initialisation,
            pa.concat_tables([run_at(level, label, initialisation.name) for label, level in levels.items()]),
        )
        advance(1)


@pytest.fixture(autouse=True)
def _nothing_is_flown_or_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Campaigns and pictures have tests of their own; they take all but a few seconds of the time."""
    monkeypatch.setattr(workers, "compute", write_runs)
    monkeypatch.setattr(command, "_DENSITIES", (0.0,))
    monkeypatch.setattr(command, "_WORLDS", 2)
    monkeypatch.setattr(command, "_VIEWS", 2)
    for figure in ("curves", "differences", "distributions", "histograms", "run_panel", "trajectories"):
        monkeypatch.setattr(report, figure, lambda *_arguments, **_options: None)
    monkeypatch.setattr(report, "save", lambda _figure, folder, name: (folder / f"{name}.png").write_bytes(b"picture"))


def reproduce(*options: object) -> int:
    return exit_status(["lab", "reproduce", "--initialisations", "3", *options])


@pytest.mark.parametrize("names", [NEEDED, pytest.param(EVERY, marks=pytest.mark.slow)], ids=len)
def test_the_document_is_written_with_its_figures_and_renewed_between_its_marks(
    names: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (studies, document):
        monkeypatch.setattr(module, "STUDIES", tuple(study for study in STUDIES if study.name in names))
    out, path = tmp_path / "runs", tmp_path / "docs" / "figures.md"
    assert reproduce("--out", out, "--document", path) == 0
    assert capsys.readouterr().out.strip() == str(path)
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# Results of the swarm strategies\n")
    headings = ("### The forest", "### Claims of the paper", "### Goals of aos-apso")
    assert all(heading in text for heading in headings)
    assert "| V from 5 s on: +0.25, the interval's lower end above +0.20 | +0.300 (+0.300 to +0.300) | yes |" in text
    pictures = [f"figures/{name}-{figure}.png" for name in names for figure in FIGURES[name]]
    assert [picture for picture in pictures if f"({picture})" not in text] == []
    assert all((path.parent / picture).is_file() for picture in pictures)

    steps = sorted(out.glob("*/steps/*.parquet"))
    assert len(steps) == len(names) * 3
    computed_ns = [step.stat().st_mtime_ns for step in steps]
    path.write_text(
        f"Our words.\n{text.partition(BEGIN_MARK)[1]}\nold\n{END_MARK}\nOur discussion.\n", encoding="utf-8"
    )
    monkeypatch.setattr(document, "write_report", lambda *_arguments, **_options: None)  # The pictures are there.
    assert reproduce("--out", out, "--document", path) == 0
    assert [step.stat().st_mtime_ns for step in steps] == computed_ns
    renewed = path.read_text(encoding="utf-8")
    assert renewed == f"Our words.\n{text[text.index(BEGIN_MARK) :]}Our discussion.\n"


def test_a_document_that_would_be_overwritten_is_refused_before_anything_is_computed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "essay.md"
    path.write_text("An essay.\n", encoding="utf-8")
    assert reproduce("--out", tmp_path / "runs", "--document", path) == 2
    assert "essay.md would be overwritten" in capsys.readouterr().err
    assert path.read_text(encoding="utf-8") == "An essay.\n"
    assert not (tmp_path / "runs").exists()
