"""``python -m aos_sim``: the simulated swarm without the rest of the command line."""

from __future__ import annotations

import sys

import typer

from aos_gcs.errors import AosError
from aos_sim.cli import sim


def main() -> None:
    """Run the command; a user's mistake becomes one sentence and exit code 2."""
    try:
        typer.run(sim)
    except AosError as error:
        sys.stderr.write(f"{error}\n")
        sys.exit(2)


if __name__ == "__main__":
    main()
