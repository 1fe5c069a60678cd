"""``aos-gcs plan-aperture``: proposal of the number and spacing of drones for a forest."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Annotated

import typer


def plan_aperture(
    *,
    altitude: Annotated[
        float, typer.Option(metavar="M", help="Height of the lowest layer above ground, metres.")
    ] = 35.0,
    fov: Annotated[float, typer.Option(metavar="DEG", help="Smaller field of view of the cameras, degrees.")] = 50.0,
    canopy_height: Annotated[float, typer.Option(metavar="M", help="Height of the tree tops, metres.")] = 18.0,
    crown_base: Annotated[float, typer.Option(metavar="M", help="Height at which crowns begin, metres.")] = 6.0,
    occluder_size: Annotated[
        float, typer.Option(metavar="M", help="Diameter of twigs with their leaves, metres.")
    ] = 1.0,
    occlusion: Annotated[
        float, typer.Option(metavar="SHARE", help="Share of the ground that one image does not see, 0 to 1.")
    ] = 0.85,
    saturation: Annotated[
        float,
        typer.Option(
            metavar="SHARE", help="Required visibility as a share of that of an unlimited number of vehicles."
        ),
    ] = 0.95,
    layer_spacing: Annotated[
        float | None,
        typer.Option(
            metavar="M",
            help="Vertical distance of two vehicles, metres; 0: all at one altitude (default: that of missions).",
        ),
    ] = None,
    drones: Annotated[int | None, typer.Option(help="Number of vehicles; default: as many as proposed.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the proposal as one JSON object.")] = False,
) -> None:
    """Propose spacing (c4), number and altitude layers of vehicles for a forest, with the reasons.

    The statistics assume occluders of one size at random places; docs/research/imaging.md compares them with forests.
    """
    from aos_gcs.imaging import aperture  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.planning.settings import FlightSettings  # noqa: PLC0415 - the same

    plan = aperture.plan_aperture(
        altitude_m=altitude,
        fov_rad=math.radians(fov),
        canopy_height_m=canopy_height,
        crown_base_m=crown_base,
        occluder_size_m=occluder_size,
        occlusion=occlusion,
        saturation=saturation,
        layer_spacing_m=FlightSettings().layer_spacing_m if layer_spacing is None else layer_spacing,
        drones=drones,
    )
    if as_json:
        typer.echo(json.dumps(dataclasses.asdict(plan), allow_nan=False))
        return
    typer.echo(f"spacing c4: {plan.spacing_m:.1f} m")
    typer.echo(f"drones: {plan.drones}")
    typer.echo(f"layers: {', '.join(f'{height_m:g}' for height_m in plan.layers_m)} m above the ground")
    typer.echo(f"visibility of the integral: {plan.visibility:.2f} (one image: {plan.single_visibility:.2f})")
    typer.echo(f"seen by at least one drone: {plan.seen_at_least_once:.0%} of the ground")
    for reason in plan.reasons:
        typer.echo(f"- {reason}")
