"""Build hook: a wheel or source archive contains the dashboard."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class DashboardBuildHook(BuildHookInterface):
    """Runs the dashboard's build before the files of a distribution are collected."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002 (the hook's signature)
        """Bring the page up to date; not for editable installs, whose owner builds it when it is wanted."""
        if version == "editable":
            return
        script = Path(self.root, "scripts", "build_dashboard.py")
        if subprocess.run([sys.executable, script], check=False).returncode:  # noqa: S603 (our own script)
            sys.exit(1)  # the script has said why; a traceback would bury it
