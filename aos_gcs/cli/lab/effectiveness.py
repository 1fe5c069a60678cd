"""``aos-gcs lab effectiveness`` and ``aos-gcs lab fit-person``: how often 'a person is here' is right."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cluster import check_jobs
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.input_values import finite_numbers
from aos_gcs.process import use_one_opencv_thread


def effectiveness(
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the study; an existing study continues.")],
    scenes: Annotated[int, typer.Option(help="Scenes with a person, and as many without, per density.")] = 100,
    densities: Annotated[str, typer.Option(help="Trees per hectare, separated by commas.")] = "300,400,500",
    seed: Annotated[int, typer.Option(help="Random seed of the first scene; the others count up from it.")] = 0,
    strategy: Annotated[str, typer.Option(help="Name of the swarm's strategy.")] = "aos-apso",
    vehicles: Annotated[int, typer.Option(help="Number of vehicles.")] = 10,
    image_size: Annotated[int, typer.Option(metavar="PX", help="Edge of the square images.")] = 512,
    jobs: Annotated[int, typer.Option(help="Number of processes on this machine.", callback=check_jobs)] = 1,
    model: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Model of persons (default: the built-in one).")
    ] = None,
) -> None:
    """Fly simulated scenes with and without a person, and report precision, recall and position error.

    Vehicles and cameras err as in the field. Results are written after each scene: the same command goes on where it
    was stopped. See docs/effectiveness.md.
    """
    use_one_opencv_thread()
    from aos_gcs.cli.output import progress  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.imaging.persons.classifier import read_model  # noqa: PLC0415
    from aos_gcs.lab.effectiveness.report import (  # noqa: PLC0415
        Rule,
        as_markdown,
        calibration_as_text,
        decide,
        summarise,
    )
    from aos_gcs.lab.effectiveness.store import StudyFolder, missing  # noqa: PLC0415
    from aos_gcs.lab.effectiveness.study import StudySettings, scene_keys, study_scenes  # noqa: PLC0415
    from aos_gcs.lab.scenes import PositionGrade  # noqa: PLC0415

    if scenes < 1 or seed < 0:
        raise ConfigurationError(f"--scenes must be at least 1 and --seed at least 0, but are {scenes} and {seed}.")
    keys = scene_keys(parse_densities(densities), seed, scenes)
    settings = StudySettings(strategy=strategy, vehicles=vehicles, image_size_px=image_size)
    persons = None if model is None else read_model(model)
    folder = StudyFolder(out, settings)
    todo = missing(keys, folder.results())
    with progress("Scenes", len(todo)) as advance:
        for result in study_scenes(todo, settings, jobs):
            folder.append(result)
            advance(1)
    chosen = set(keys)
    results = [result for result in folder.results() if result.key in chosen]
    decisions = [decide(result, grade, rule, persons) for rule in Rule for grade in PositionGrade for result in results]
    summary = f"{as_markdown(summarise(decisions))}\n{calibration_as_text(results, persons)}"
    folder.write_decisions(decisions)
    folder.write_summary(summary)
    typer.echo(summary, nl=False)


def fit_person(
    *,
    study: Annotated[
        list[Path],
        typer.Option(metavar="DIR", help="Folder of a study (aos-gcs lab effectiveness); repeat it for more."),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="File for the model, as JSON.")],
    odds: Annotated[
        float, typer.Option(help="Ratio of persons to other warm bodies where the model is to be used.")
    ] = 0.25,
    folds: Annotated[
        int,
        typer.Option(help="Number of parts for cross-validation: each is judged by a model of the others; 0: none."),
    ] = 0,
) -> None:
    """Fit the model that tells persons from other warm bodies to the scenes of one study or several.

    The model's file names its scenes and the day.
    Judge it on scenes of other seeds: aos-gcs lab effectiveness --model FILE --seed N.
    """
    from aos_gcs.clock import today_utc  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.exports.files import check_suffix, check_writable  # noqa: PLC0415
    from aos_gcs.imaging.persons.classifier import fit_person_model, write_model  # noqa: PLC0415
    from aos_gcs.lab.effectiveness.report import (  # noqa: PLC0415
        as_markdown,
        decide_by_others,
        describe,
        labelled_bodies,
        summarise,
    )
    from aos_gcs.lab.effectiveness.store import SCENES_FILE, read_results  # noqa: PLC0415

    if folds < 0 or folds == 1:
        raise ConfigurationError(f"--folds must be 0 or at least 2, but is {folds}.")
    if not (math.isfinite(odds) and odds > 0.0):
        raise ConfigurationError(f"--odds must be above 0, but is {odds:g}.")
    check_suffix("--out", out, ".json")
    check_writable(out)
    for folder in study:
        if not (folder / SCENES_FILE).is_file():
            raise InputDataError(f"--study {folder} holds no scenes: give the --out of aos-gcs lab effectiveness.")
    results = [result for folder in study for result in read_results(folder)]
    evidence, is_person = labelled_bodies(results)
    fitted = fit_person_model(evidence, is_person, odds)
    write_model(out, replace(fitted, fitted_to=describe(results), fitted_on=today_utc()))
    typer.echo(f"{out}: fitted to {sum(is_person)} persons and {len(is_person) - sum(is_person)} other bodies")
    if folds:
        typer.echo(as_markdown(summarise(decide_by_others(results, folds))), nl=False)


def parse_densities(text: str) -> list[float]:
    """Return the value of ``--densities``, trees per hectare.

    Raises:
        ConfigurationError: the text is not a list of different numbers that the simulator can build.
    """
    from aos_gcs.lab.worlds import MAX_TREES_PER_HA  # noqa: PLC0415 - keeps the other commands' help fast

    densities = parse_numbers("--densities", text)
    if not all(0.0 <= density <= MAX_TREES_PER_HA for density in densities):
        raise ConfigurationError(f"--densities must lie within 0 and {MAX_TREES_PER_HA:g}, but is {text}.")
    return densities


def parse_numbers(option: str, text: str) -> list[float]:
    """Return the value of an option that lists numbers.

    Raises:
        ConfigurationError: the text is not a list of different finite numbers.
    """
    numbers = finite_numbers(text)
    if not numbers or len(set(numbers)) < len(numbers):
        raise ConfigurationError(f"{option} must be numbers separated by commas, each once, but is {text!r}.")
    return numbers
