"""Arguments of the interface's process."""

from __future__ import annotations

import json
import logging
from dataclasses import dataclass, field
from pathlib import Path

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.operator_file import FILE_NAME, OperatorFile
from aos_gcs.config.model import ApiConfig
from aos_gcs.runtime.sign_in import OperatorSecrets


@dataclass(frozen=True, slots=True)
class ApiStart:
    """Files and settings of the dashboard; told by the connection, since the code is secret."""

    api: ApiConfig
    code: str
    """Code by which operators sign in."""
    folder: Path
    """Folder of the missions, with the file that remembers who has signed in."""
    mission_folder: Path
    log_level: int = field(default_factory=lambda: logging.getLogger().getEffectiveLevel())

    def secrets(self) -> OperatorSecrets:
        """Return the code or the accounts, and the file that remembers who has signed in."""
        accounts = None if self.api.accounts is None else AccountFile(self.api.accounts)
        return OperatorSecrets(self.code, OperatorFile(self.folder / FILE_NAME), accounts)

    def to_json(self) -> bytes:
        """Return all of it as JSON."""
        folders = {"folder": str(self.folder), "mission_folder": str(self.mission_folder)}
        api = self.api.model_dump(mode="json")
        return json.dumps({"api": api, "code": self.code, "log_level": self.log_level, **folders}).encode()

    @classmethod
    def from_json(cls, text: bytes) -> ApiStart:
        """Return what :meth:`to_json` has written."""
        fields = json.loads(text)
        api, folder, mission_folder = ApiConfig(**fields["api"]), Path(fields["folder"]), Path(fields["mission_folder"])
        return cls(api, fields["code"], folder, mission_folder, fields["log_level"])
