"""``aos-gcs lab search``: whole searches of hectares, what they find, when, and at what rate."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cli.lab.effectiveness import parse_densities, parse_numbers
from aos_gcs.cluster import check_jobs
from aos_gcs.errors import ConfigurationError
from aos_gcs.process import use_one_opencv_thread


def search(
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the study; an existing study continues.")],
    document: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Markdown file to write or renew, such as docs/searches.md.")
    ] = None,
    searches: Annotated[int, typer.Option(help="Persons that are searched for, per density.")] = 100,
    densities: Annotated[str, typer.Option(help="Trees per hectare, separated by commas.")] = "300",
    hectares: Annotated[str, typer.Option(help="Sizes of the square areas, 0.1 to 50, separated by commas.")] = "4",
    vehicles: Annotated[str, typer.Option(help="Numbers of vehicles, separated by commas.")] = "1,3,10",
    methods: Annotated[
        str,
        typer.Option(
            help="Flights: planned, twice, prior, line, chosen, chosen_legs, stops, single, lawnmower, separated by "
            "commas."
        ),
    ] = "planned,line,stops,single,lawnmower",
    posture: Annotated[str, typer.Option(help="Posture of the person: standing, sitting or lying.")] = "standing",
    pod: Annotated[float, typer.Option(help="Probability of detection that the planned flights are to reach.")] = 0.9,
    rate: Annotated[float, typer.Option(help="Frames per second of each camera.")] = 2.0,
    spread: Annotated[
        float | None,
        typer.Option(
            metavar="SHARE",
            help="Draw persons about a last known point, half of them within this share of the area's side.",
        ),
    ] = None,
    passes: Annotated[int, typer.Option(help="Flights over the area at most, until the person is noticed.")] = 8,
    images: Annotated[
        int, typer.Option(help="Searches per density whose planned flights are rendered, too; each takes a minute.")
    ] = 0,
    seed: Annotated[int, typer.Option(help="Random seed of the first person; the others count up from it.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as one JSON object.")] = False,
    jobs: Annotated[int, typer.Option(help="Number of processes on this machine.", callback=check_jobs)] = 1,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Address of a Dask scheduler, such as tcp://10.0.0.1:8786.")
    ] = None,
) -> None:
    """Search square areas for persons at random places by several flights, and compare what they find.

    Rays tell what each frame shows of the person between the trees. All flights search for the same persons, again and
    again until they are noticed. Results are written after each person: the same command goes on where it was stopped.
    See docs/searches.md.
    """
    use_one_opencv_thread()
    from dataclasses import asdict  # noqa: PLC0415 - keeps the other commands' help fast
    from functools import partial  # noqa: PLC0415
    from importlib.metadata import version  # noqa: PLC0415

    from aos_gcs.cli.output import progress  # noqa: PLC0415
    from aos_gcs.groundmap.detection import Posture  # noqa: PLC0415
    from aos_gcs.lab.search.model import Method, SearchStudySettings, search_keys  # noqa: PLC0415
    from aos_gcs.lab.search.report import as_markdown, search_frame, summarise, write_document  # noqa: PLC0415
    from aos_gcs.lab.search.store import SearchFolder  # noqa: PLC0415
    from aos_gcs.lab.search.study import search_for_person  # noqa: PLC0415
    from aos_gcs.lab.workers import compute_each  # noqa: PLC0415

    for option, given, known in (("--methods", methods.split(","), Method), ("--posture", [posture], Posture)):
        for name in given:
            if name not in tuple(known):
                raise ConfigurationError(f"{option} must be one of {', '.join(known)}, but is {name!r}.")
    numbers = parse_numbers("--vehicles", vehicles)
    if not all(map(float.is_integer, numbers)):
        raise ConfigurationError(f"--vehicles must be whole numbers, but is {vehicles!r}.")
    settings = SearchStudySettings(
        hectares=tuple(parse_numbers("--hectares", hectares)),
        vehicles=tuple(map(int, numbers)),
        methods=tuple(Method(name) for name in methods.split(",")),
        posture=Posture(posture),
        pod=pod,
        rate_hz=rate,
        passes=passes,
        spread=spread,
        images=images,
        version=version("aos-gcs"),
    )
    keys = search_keys(parse_densities(densities), searches, seed)
    # Before hours of work: a document that cannot be renewed is refused at once.
    frame = None if document is None else search_frame(document)
    folder = SearchFolder(out, settings)
    known_keys = {result.key for result in folder.results()}
    missing = tuple(key for key in keys if key not in known_keys)
    with progress("Searches", len(missing)) as advance:
        work = partial(search_for_person, settings)
        for _, result in compute_each(work, missing, jobs=jobs, scheduler=scheduler):
            folder.append(result)
            advance(1)
    figures = summarise([result for result in folder.results() if result.key in set(keys)])
    text = as_markdown(figures)
    if document is not None and frame is not None:
        write_document(document, frame, settings, figures, text)
    typer.echo(json.dumps(asdict(figures)) if as_json else text, nl=as_json)
