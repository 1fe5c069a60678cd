"""The folder of a campaign: its manifest and a Parquet file per finished initialisation.

::

    DIR/campaign.json            what is computed (aos_gcs.lab.campaign.Campaign.manifest)
    DIR/steps/00042.parquet      the rows of all strategies in one initialisation (aos_gcs.lab.rows)

Files appear whole or not at all, so that an interrupted campaign goes on where it was.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.lab.campaign import Campaign, parse_manifest
from aos_gcs.lab.initialisation import Initialisation
from aos_gcs.lab.tables import SCHEMA

MANIFEST = "campaign.json"
STEPS = "steps"

_DIGEST_KEY = b"aos_gcs.campaign"


@dataclass(frozen=True, slots=True)
class ResultFolder:
    """A campaign and where its results are."""

    folder: Path
    campaign: Campaign

    def missing(self) -> tuple[Initialisation, ...]:
        """Return the initialisations that have no results yet.

        Raises:
            InputDataError: a result file is damaged or belongs to another campaign.
        """
        return tuple(
            initialisation
            for initialisation in self.campaign.initialisations
            if not self._is_finished(self._path(initialisation))
        )

    def write(self, initialisation: Initialisation, table: pa.Table) -> None:
        """Add the results of an initialisation.

        Raises:
            ConfigurationError: the file cannot be written.
        """
        path = self._path(initialisation)
        temporary = path.with_suffix(".tmp")
        labelled = table.replace_schema_metadata({_DIGEST_KEY: self.campaign.digest.encode()})
        try:
            pq.write_table(labelled, temporary)
            temporary.replace(path)
        except OSError as error:
            raise ConfigurationError(f"Cannot write {path}: {error.strerror or error}.") from error

    def read(self) -> pa.Table:
        """Return all rows there are, in the order of the campaign's initialisations; of :data:`SCHEMA`.

        Raises:
            InputDataError: a result file is damaged or belongs to another campaign.
        """
        paths = [self._path(initialisation) for initialisation in self.campaign.initialisations]
        tables = [pq.read_table(path).replace_schema_metadata() for path in paths if self._is_finished(path)]
        return pa.concat_tables([SCHEMA.empty_table(), *tables])

    def _path(self, initialisation: Initialisation) -> Path:
        return self.folder / STEPS / f"{initialisation.name}.parquet"

    def _is_finished(self, path: Path) -> bool:
        if not path.exists():
            return False
        try:
            schema = pq.read_schema(path)
        except (pa.ArrowException, OSError) as error:
            raise InputDataError(f"{path} is damaged ({error}); delete it and run the campaign again.") from error
        if (schema.metadata or {}).get(_DIGEST_KEY) != self.campaign.digest.encode():
            raise InputDataError(
                f"{path} belongs to another campaign than {MANIFEST} says; delete it and run the campaign again."
            )
        return True


def create_results(folder: Path, campaign: Campaign) -> ResultFolder:
    """Return the result folder of a campaign: a new one, or the one that an earlier call has begun.

    Raises:
        ConfigurationError: the folder holds something else or cannot be written.
        InputDataError: its manifest cannot be read.
    """
    path = folder / MANIFEST
    if path.exists():
        differences = _differences(_read_manifest(path), campaign.manifest())
        if differences:
            raise ConfigurationError(
                f"{folder} holds another campaign: {'; '.join(differences)}. Choose another --out, or delete it."
            )
    else:
        _begin(folder, campaign)
    return ResultFolder(folder, campaign)


def open_results(folder: Path) -> ResultFolder:
    """Return the results of a campaign, finished or not.

    Raises:
        InputDataError: the folder is none of a campaign.
    """
    path = folder / MANIFEST
    if not path.exists():
        raise InputDataError(f"{folder} is not a campaign: it has no {MANIFEST}; give the --out of aos-gcs lab run.")
    return ResultFolder(folder, parse_manifest(_read_manifest(path), str(path)))


def _begin(folder: Path, campaign: Campaign) -> None:
    # Nothing but the empty folder of steps is there when an earlier call was cut off just here.
    known = {folder / STEPS, folder / STEPS / f"{MANIFEST}.tmp"}
    if folder.exists() and (not folder.is_dir() or not known.issuperset(folder.rglob("*"))):
        raise ConfigurationError(
            f"{folder} is not empty and has no {MANIFEST}: it is not a campaign, or has lost this file. "
            "Choose another --out, or delete it."
        )
    try:
        (folder / STEPS).mkdir(parents=True, exist_ok=True)
        # Last, and as a whole: a folder with a manifest is complete.
        temporary = folder / STEPS / f"{MANIFEST}.tmp"
        temporary.write_text(json.dumps(campaign.manifest(), indent=1) + "\n", encoding="utf-8")
        temporary.replace(folder / MANIFEST)
    except OSError as error:
        raise ConfigurationError(f"Cannot write into {folder} (--out): {error.strerror or error}.") from error


def _read_manifest(path: Path) -> dict[str, Any]:
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputDataError(
            f"{path} cannot be read ({error}); delete {path.parent} and run the campaign again."
        ) from error
    if not isinstance(manifest, dict):
        raise InputDataError(f"{path} is not the manifest of a campaign; delete {path.parent} and run it again.")
    return manifest


def _differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """Return what differs between two manifests, in words."""
    texts = []
    for name in sorted(set(there) | set(here)):
        old, new = there.get(name), here.get(name)
        if old == new:
            continue
        if isinstance(old, dict) and isinstance(new, dict):
            texts += _differences(old, new)
        elif isinstance(old, list) and isinstance(new, list):
            texts.append(f"{name} differ ({len(old)} there, {len(new)} here)")
        else:
            texts.append(f"{name} is {old!r} there and {new!r} here")
    return texts
