"""``aos-gcs lab missions``: how often the claims of whole missions are right."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cli.lab.effectiveness import parse_densities
from aos_gcs.cluster import check_jobs
from aos_gcs.process import use_one_opencv_thread


def missions(
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the study; an existing study continues.")],
    document: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Markdown file to write or renew, such as docs/missions.md.")
    ] = None,
    with_person: Annotated[
        int, typer.Option("--missions", help="Missions with a person, per density, condition and grade of errors.")
    ] = 100,
    without_person: Annotated[
        int, typer.Option("--no-person", help="Missions without a person, per density, condition and grade of errors.")
    ] = 100,
    densities: Annotated[str, typer.Option(help="Trees per hectare, separated by commas.")] = "300",
    conditions: Annotated[
        str,
        typer.Option(
            help="Conditions, separated by commas: cool, clear, overcast, night or warm; on the cool morning no-skin, "
            "persons-2k-cooler, persons-4k-cooler, distractors-3k-warmer, blurred, two-persons, pair or walking."
        ),
    ] = "cool",
    errors: Annotated[
        str, typer.Option(help="Grades of errors of vehicles and cameras, separated by commas: none, rtk or gnss.")
    ] = "rtk",
    seed: Annotated[int, typer.Option(help="Random seed of the first mission; the others count up from it.")] = 0,
    strategy: Annotated[str, typer.Option(help="Name of the swarm's strategy.")] = "aos-apso",
    search: Annotated[
        str,
        typer.Option(
            metavar="MODE",
            help="How the swarm flies along its legs: continuous, stops, or split, which is continuous with some "
            "vehicles that scan on while others look closely.",
            show_default="as missions do by default",
        ),
    ] = "",
    reference: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder of the same missions with another strategy, search mode, order of looks or other legs; "
            "differences to it are reported pair by pair.",
        ),
    ] = None,
    vehicles: Annotated[int, typer.Option(help="Number of vehicles.")] = 10,
    side: Annotated[float, typer.Option(metavar="M", help="Side of the search area, a square forest.")] = 60.0,
    image_size: Annotated[int, typer.Option(metavar="PX", help="Edge of the square images.")] = 512,
    terrain: Annotated[
        str,
        typer.Option(
            help="Shape of the ground: flat, hills or slope:PERCENT, rising to the north from the launch site on. "
            "Layers are as much higher as the highest ground that is flown over, unless they follow the ground."
        ),
    ] = "flat",
    layer_spacing: Annotated[
        float | None,
        typer.Option(
            metavar="M", help="Vertical distance of two altitude layers.", show_default="2.5; 7.5 with --errors gnss"
        ),
    ] = None,
    launch_spacing: Annotated[
        float | None,
        typer.Option(metavar="M", help="Distance of two launch points.", show_default="5; 10 with --errors gnss"),
    ] = None,
    follow_ground: Annotated[
        bool, typer.Option("--follow-ground", help="Let the altitude layers follow the ground of --terrain.")
    ] = False,
    surface: Annotated[
        str,
        typer.Option(
            metavar="terrain|level",
            help="Surface that the focal plane follows over the relief of --terrain.",
            show_default="as missions do by default",
        ),
    ] = "",
    looks: Annotated[
        str,
        typer.Option(
            metavar="first|gain",
            help="Order of close looks: first (always at once), or gain (at once where that is expected to find a "
            "person sooner than scanning on, otherwise behind the last leg).",
            show_default="as missions do by default",
        ),
    ] = "",
    pod: Annotated[
        float | None,
        typer.Option(
            metavar="P",
            help="Plan spacings and speed for this probability of detection of a standing person, and compare the "
            "persons that were noticed and announced with what the plan promises.",
            show_default="spacings and speed as missions have by default",
        ),
    ] = None,
    legs: Annotated[
        str,
        typer.Option(
            metavar="planned|chosen",
            help="Fly parallel legs, or legs chosen one after the other, each where the swarm's line expects to gain "
            "most probability of detection per second, until that of --pod is expected.",
        ),
    ] = "planned",
    jobs: Annotated[int, typer.Option(help="Number of processes on this machine.", callback=check_jobs)] = 1,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Address of a Dask scheduler, such as tcp://10.0.0.1:8786.")
    ] = None,
) -> None:
    """Fly whole missions in virtual time, and report how many claims are right, what they cost, and how safe it is.

    Coordinator, safety checks, strategy and imaging are those of real missions; vehicles, cameras and forest are
    simulated in the same process, with animals, stones, stumps, cloths and puddles. Results are written after each
    mission: the same command goes on where it was stopped. See docs/missions.md.
    """
    use_one_opencv_thread()
    from functools import partial  # noqa: PLC0415 - keeps the other commands' help fast
    from importlib.metadata import version  # noqa: PLC0415

    from aos_gcs.cli.output import progress  # noqa: PLC0415
    from aos_gcs.lab.missions.model import MissionsSettings, missing, mission_keys  # noqa: PLC0415
    from aos_gcs.lab.missions.pairs import pair_missions, pairs_as_markdown  # noqa: PLC0415
    from aos_gcs.lab.missions.report import as_markdown, missions_frame, summarise, write_document  # noqa: PLC0415
    from aos_gcs.lab.missions.store import MissionsFolder, reference_missions  # noqa: PLC0415
    from aos_gcs.lab.workers import compute_each  # noqa: PLC0415
    from aos_gcs.runtime.simulated.mission_study import check_flights, fly_mission  # noqa: PLC0415

    keys = mission_keys(
        parse_densities(densities),
        conditions.split(","),
        errors.split(","),
        seed,
        with_person=with_person,
        without_person=without_person,
    )
    settings = MissionsSettings(
        strategy=strategy,
        vehicles=vehicles,
        side_m=side,
        image_size_px=image_size,
        version=version("aos-gcs"),
        terrain=terrain,
        layer_spacing_m=layer_spacing,
        launch_spacing_m=launch_spacing,
        follow_ground=follow_ground,
        search_mode=search,
        surface=surface,
        pod=pod,
        looks=looks,
        legs=legs,
    )
    # Before hours of work: a document that cannot be renewed, or a reference that does not fit, is refused at once.
    frame = None if document is None else missions_frame(document)
    rival = None if reference is None else reference_missions(reference, settings)
    check_flights(settings, keys)
    folder = MissionsFolder(out, settings)
    todo = missing(keys, folder.results())
    with progress("Missions", len(todo)) as advance:
        for _, result in compute_each(partial(fly_mission, settings), todo, jobs=jobs, scheduler=scheduler):
            folder.append(result)
            advance(1)
    chosen = set(keys)
    results = [result for result in folder.results() if result.key in chosen]
    groups = summarise(results, vehicles)
    text = as_markdown(groups)
    if rival is not None:
        text += "\n" + pairs_as_markdown(pair_missions(results, rival[1]), settings.name, rival[0])
    folder.write_summary(text)
    if document is not None and frame is not None:
        write_document(document, frame, settings, groups, text)
    typer.echo(text, nl=False)
