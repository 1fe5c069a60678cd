"""Build hook: a wheel or source archive contains the dashboard, and an installation the kernels of imaging."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class AosGcsBuildHook(BuildHookInterface):
    """Runs the builds of the dashboard and of the kernels before the files of a distribution are collected."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Bring both up to date; not the page for editable installs, whose owner builds it when it is wanted."""
        if self.target_name == "wheel":
            self._build_kernels(build_data)
        if version == "editable":
            return
        script = Path(self.root, "scripts", "build_dashboard.py")
        if subprocess.run([sys.executable, script], check=False).returncode:  # noqa: S603 (our own script)
            sys.exit(1)  # the script has said why; a traceback would bury it

    def _build_kernels(self, build_data: dict[str, Any]) -> None:
        """Compile the kernels where there is a compiler; a wheel with them is one for this kind of machine."""
        script = Path(self.root, "scripts", "build_kernels.py")
        subprocess.run([sys.executable, script], check=False)  # noqa: S603 (our own script)
        libraries = sorted(Path(self.root, "aos_gcs", "imaging", "native").glob("*.so"))
        if libraries:
            build_data["artifacts"] += [path.relative_to(self.root).as_posix() for path in libraries]
            build_data["pure_python"] = False
            platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            build_data["tag"] = f"py3-none-{platform}"
