"""Fly many random missions, or repeat one: python -m tests.campaign --help."""

from __future__ import annotations

import argparse
import os
import sys

from tests.campaign.runner import fly_all, repeat


def main() -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign", description=__doc__)
    parser.add_argument("--missions", type=int, default=500, help="number of missions; their seeds count from --first")
    parser.add_argument("--first", type=int, default=1, help="first seed")
    parser.add_argument("--seed", type=int, help="repeat the mission of one seed, with its trace")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes side by side")
    parser.add_argument("--no-shrink", action="store_true", help="do not look for the smallest failing part")
    options = parser.parse_args()
    if options.seed is not None:
        return repeat(options.seed, is_shrunk=not options.no_shrink)
    return fly_all(range(options.first, options.first + options.missions), options.jobs, not options.no_shrink)


if __name__ == "__main__":
    sys.exit(main())
