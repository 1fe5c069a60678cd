"""``aos-gcs lab``: compare swarm strategies in simulated forests."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aos_gcs.cli.lab.detectability import detectability
from aos_gcs.cli.lab.effectiveness import effectiveness, fit_person, parse_densities
from aos_gcs.cli.lab.missions import missions
from aos_gcs.cli.lab.recordings import recordings
from aos_gcs.cli.lab.reproduce import reproduce
from aos_gcs.cli.lab.search import search
from aos_gcs.cluster import check_jobs

if TYPE_CHECKING:
    from aos_gcs.lab.initialisation import Initialisation
    from aos_gcs.lab.scenario import Scenario

lab = typer.Typer(no_args_is_help=True, add_completion=False)


@lab.callback()
def _about() -> None:
    """Compare swarm strategies in simulated forests."""
    from aos_gcs.extras import load_extra  # noqa: PLC0415 - keeps the other commands' help fast

    load_extra("pyarrow", "lab", "The laboratory")


@lab.command("run")
def run(
    *,
    strategies: Annotated[
        str, typer.Option(help="Strategies separated by commas, with parameters: aos-pso,aos-apso(gamma=0.8).")
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the results; an interrupted run continues.")],
    initialisations: Annotated[
        str, typer.Option(help="Number of initialisations to draw, 'paper' for the three fixed ones, or a TOML file.")
    ] = "100",
    seed: Annotated[int, typer.Option(help="Random seed for the drawn initialisations.")] = 0,
    scenario: Annotated[
        Path | None, typer.Option(metavar="FILE", help="TOML or JSON with fields of the scenario.")
    ] = None,
    duration: Annotated[float | None, typer.Option(metavar="S", help="Simulated seconds per run.")] = None,
    density: Annotated[float | None, typer.Option(metavar="TREES", help="Trees per hectare.")] = None,
    forest: Annotated[str | None, typer.Option(help="Type of the trees: broadleaf or conifer.")] = None,
    drones: Annotated[int | None, typer.Option(help="Number of vehicles.")] = None,
    posture: Annotated[str | None, typer.Option(help="Posture of the target: standing, sitting or lying.")] = None,
    target_speed: Annotated[float | None, typer.Option(metavar="M/S", help="Speed of the target (0: still).")] = None,
    fidelity: Annotated[str | None, typer.Option(help="geometric (rays, fast) or imaging (rendered images).")] = None,
    errors: Annotated[
        str | None, typer.Option(help="Errors of vehicles and cameras in rendered images: none, rtk or gnss.")
    ] = None,
    time_model: Annotated[str | None, typer.Option(help="paper (10 m/s, nothing else takes time) or dynamics.")] = None,
    oracle: Annotated[
        bool, typer.Option("--oracle", help="Also compute the best positions, with full knowledge of the forest.")
    ] = False,
    jobs: Annotated[int, typer.Option(help="Number of processes on this machine.", callback=check_jobs)] = 1,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Address of a Dask scheduler, such as tcp://10.0.0.1:8786.")
    ] = None,
) -> None:
    """Run strategies through initialisations of a scenario; write a row per step.

    Options overrule the scenario's file; what neither says is as in the paper: ten drones, 300 trees per hectare, a
    standing person who stays, 20 seconds.
    """
    from aos_gcs.cli.output import progress  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.lab.campaign import Campaign  # noqa: PLC0415
    from aos_gcs.lab.results import create_results  # noqa: PLC0415
    from aos_gcs.lab.strategies import parse_strategies  # noqa: PLC0415
    from aos_gcs.lab.workers import compute  # noqa: PLC0415

    options = {
        "duration_s": duration,
        "trees_per_ha": density,
        "forest": forest,
        "drones": drones,
        "posture": posture,
        "target_speed_mps": target_speed,
        "fidelity": fidelity,
        "errors": errors,
        "time_model": time_model,
    }
    chosen = _scenario(scenario, {name: value for name, value in options.items() if value is not None})
    starts = _initialisations(initialisations, seed, chosen)
    campaign = Campaign(chosen, parse_strategies(strategies), starts, oracle=oracle)
    results = create_results(out, campaign)
    missing = len(results.missing())
    if done := len(campaign.initialisations) - missing:
        typer.echo(f"{done} of {len(campaign.initialisations)} initialisations are there already.", err=True)
    with progress("Initialisations", missing) as advance:
        compute(results, advance, jobs=jobs, scheduler=scheduler)
    counts = f"strategies: {len(campaign.strategies)}, initialisations: {len(campaign.initialisations)}"
    typer.echo(f"{results.read().num_rows} rows in {out} ({counts})")


@lab.command("report")
def report(
    *,
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a campaign (lab run --out).")],
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder of the report (default: DIR/report).")] = None,
    reference: Annotated[
        str | None, typer.Option(help="Strategy that the others are compared with (default: the first).")
    ] = None,
    runs: Annotated[int, typer.Option(help="Number of initialisations whose single runs are drawn.", min=0)] = 1,
) -> None:
    """Report on a campaign: Markdown, figures as PNG and SVG, and the numbers as CSV."""
    from aos_gcs.lab.report import compare, write_report  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.lab.results import open_results  # noqa: PLC0415

    results = open_results(folder)
    labels = [choice.label for choice in results.campaign.strategies]
    comparison = compare(results.campaign.scenario, labels, results.read())
    typer.echo(write_report(comparison, out or folder / "report", reference=reference or labels[0], shown_runs=runs))


@lab.command("calibrate")
def calibrate(
    *,
    densities: Annotated[str, typer.Option(help="Trees per hectare, separated by commas.")] = "300,400,500",
    worlds: Annotated[int, typer.Option(help="Forests per density.", min=2)] = 20,
    views: Annotated[int, typer.Option(help="Views per forest.", min=1)] = 40,
    forest: Annotated[str, typer.Option(help="broadleaf or conifer.")] = "broadleaf",
    posture: Annotated[str, typer.Option(help="Posture of the target: standing, sitting or lying.")] = "standing",
    seed: Annotated[int, typer.Option(help="Random seed for the forests and views.", min=0)] = 0,
) -> None:
    """Measure how much of the target single views see through the laboratory's forests."""
    from aos_gcs.cli.output import progress  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.lab.calibration import single_view_visibility  # noqa: PLC0415
    from aos_gcs.lab.scenario import parse_scenario  # noqa: PLC0415

    typer.echo("trees/ha  mean visibility of a view  half of the forests lie within")
    for density in parse_densities(densities):
        scenario = parse_scenario({"trees_per_ha": density, "forest": forest, "posture": posture})
        with progress(f"{density:g} trees/ha", worlds) as advance:
            result = single_view_visibility(scenario, worlds=worlds, views=views, seed=seed, advance=advance)
        mean = f"{result.mean:.3f} +- {result.standard_error:.3f}"
        typer.echo(f"{density:8g}  {mean:25s}  {result.lower_quartile:.3f} to {result.upper_quartile:.3f}")


lab.command("detectability")(detectability)
lab.command("effectiveness")(effectiveness)
lab.command("fit-person")(fit_person)
lab.command("missions")(missions)
lab.command("search")(search)
lab.command("recordings")(recordings)
lab.command("reproduce")(reproduce)


def _scenario(file: Path | None, options: dict[str, object]) -> Scenario:
    from aos_gcs.lab.scenario import load_scenario, parse_scenario  # noqa: PLC0415

    return parse_scenario({**({} if file is None else load_scenario(file)), **options})


def _initialisations(text: str, seed: int, scenario: Scenario) -> tuple[Initialisation, ...]:
    from aos_gcs.lab import initialisation  # noqa: PLC0415

    if text == "paper":
        return initialisation.paper_initialisations()
    if text.lstrip("-").isdigit():
        return initialisation.draw_initialisations(int(text), seed, scenario)
    return initialisation.load_initialisations(Path(text))
