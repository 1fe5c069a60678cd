"""Results of ``aos-gcs integrate``: options for rasters, pictures and tables, and their writing."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.anomaly_table import FORMATS, encode_anomalies
from aos_gcs.exports.files import check_apart, check_folder, check_suffix, check_writable, written_whole
from aos_gcs.exports.georeference import Georeference
from aos_gcs.exports.rasters import (
    RASTER_SUFFIXES,
    TIFF_SUFFIXES,
    MapPlace,
    world_file_path,
    write_picture,
    write_raster,
    write_world_file,
)
from aos_gcs.extras import load_extra
from aos_gcs.imaging.model import Detector, MapRaster
from aos_gcs.imaging.pictures import shade_counts, shade_integral
from aos_gcs.surveys.anomalies import MapBlob
from aos_gcs.surveys.rasters import SurveyRasters
from aos_gcs.surveys.significance import significance_limit

PANEL = "Results"
ANOMALY_PANEL = "Anomalies"

MAX_PICTURE_CELLS = 100_000_000
"""A picture is made in memory as a whole, and viewers cannot show more."""

Out = Annotated[
    Path,
    typer.Option(
        metavar="FILE.npy|FILE.tif",
        help="Integral: float32, NaN where no image covers. NumPy's (H, W) or (H, W, 3), or a GeoTIFF of a map.",
        rich_help_panel=PANEL,
    ),
]
Count = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.npy|FILE.tif",
        help="Also write the number of images that cover each pixel: uint16.",
        rich_help_panel=PANEL,
    ),
]
Png = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.png",
        help="Also write the integral as a picture with stretched contrast; beside a map, with a world file .pgw.",
        rich_help_panel=PANEL,
    ),
]
Anomaly = Annotated[
    list[Path] | None,
    typer.Option(
        metavar="FILE.npy|FILE.tif|FILE.png",
        help="Also find anomalies in every image, and write how significant each pixel is: float32, or a heat overlay. "
        "May be given several times.",
        rich_help_panel=ANOMALY_PANEL,
    ),
]
Blobs = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.geojson|FILE.json|FILE.csv",
        help="Also write a table of the anomalies of a map, the most significant first: position, area, images that "
        "agree.",
        rich_help_panel=ANOMALY_PANEL,
    ),
]
DetectorName = Annotated[
    Detector,
    typer.Option(
        "--detector",
        case_sensitive=False,
        help="Anomaly detector. The thermal detector takes grey images for thermal ones.",
        rich_help_panel=ANOMALY_PANEL,
    ),
]
MinScore = Annotated[
    float | None,
    typer.Option(
        metavar="SCORE",
        help="Score from which a pixel counts: a squared distance from the background in its standard deviations. "
        "Default: a limit of the detector that few pixels of the background exceed.",
        rich_help_panel=ANOMALY_PANEL,
    ),
]
FalseAlarmsPerHa = Annotated[
    float,
    typer.Option(
        "--false-alarms-per-ha",
        metavar="RATE",
        help="Anomalies that chance may make per hectare. Smaller rates give fewer, surer ones.",
        rich_help_panel=ANOMALY_PANEL,
    ),
]
Thumbnails = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Also write a picture of the surroundings of each row of --blobs: the map, and the significance.",
        rich_help_panel=ANOMALY_PANEL,
    ),
]


@dataclass(frozen=True, slots=True)
class ResultOptions:
    """Files to write, and the detector of anomalies.

    Raises:
        ConfigurationError: if a file cannot be written, two are the same, a suffix is not known, or a number lies
            outside its range.
    """

    out: Path
    count: Path | None
    png: Path | None
    anomaly: tuple[Path, ...]
    blobs: Path | None
    detector: Detector
    min_score: float | None
    false_alarms_per_ha: float
    thumbnails: Path | None
    ortho: bool

    def __post_init__(self) -> None:
        significance_limit(self.false_alarms_per_ha)
        if self.thumbnails is not None and self.blobs is None:
            raise ConfigurationError("--thumbnails shows the rows of a table: request one with --blobs FILE.")
        if self.min_score is not None and not self.min_score >= 0.0:
            raise ConfigurationError(f"--min-score must not be negative, got {self.min_score:g}.")
        if self.min_score is not None and self.wanted_detector is None:
            raise ConfigurationError("--min-score is for anomalies: request them with --anomaly or --blobs.")
        paths = [path for path in (self.out, self.count, self.png, *self.anomaly, self.blobs) if path is not None]
        paths += [world_file_path(path) for path in self._pictures()] if self.ortho else []
        if len({path.absolute() for path in paths}) < len(paths):
            raise ConfigurationError("--out, --count, --png, --anomaly and --blobs must name different files.")
        for path in paths:
            check_writable(path)
        if self.thumbnails is not None:
            check_folder(self.thumbnails)
        for option, named, suffixes in (
            ("--out", (self.out,), RASTER_SUFFIXES),
            ("--count", (self.count,), RASTER_SUFFIXES),
            ("--png", (self.png,), (".png",)),
            ("--anomaly", self.anomaly, (*RASTER_SUFFIXES, ".png")),
            ("--blobs", (self.blobs,), tuple(FORMATS)),
        ):
            for path in filter(None, named):
                check_suffix(option, path, *suffixes)
        if not self.ortho:
            if self.blobs is not None:
                raise ConfigurationError("--blobs lists the anomalies of a map: request one with --ortho RES.")
            for path in self._geotiffs():
                raise ConfigurationError(
                    f"Cannot write {path}: a view has no place on a map. Request a map with --ortho RES, or write .npy."
                )

    @property
    def wanted_detector(self) -> Detector | None:
        """Detector of anomalies; None where no output shows them."""
        return self.detector if self.anomaly or self.blobs is not None else None

    def check_inputs(self, inputs: Iterable[Path]) -> None:
        """Refuse results in the place of what is read.

        Raises:
            ConfigurationError: naming the result.
        """
        files = (self.out, self.count, self.png, *self.anomaly, self.blobs)
        check_apart([path for path in files if path is not None], self.thumbnails, inputs)

    def check_georeference(self, georeference: Georeference | None) -> None:
        """Refuse files that need a place on the earth where there is none, or a library that is not installed.

        Raises:
            ConfigurationError: naming the file and what is missing.
        """
        if self._geotiffs():
            load_extra("rasterio", "geo", "Writing a GeoTIFF")
        geojson = [self.blobs] if self.blobs is not None and self.blobs.suffix.lower() == ".geojson" else []
        for path in (*self._geotiffs(), *geojson):
            if georeference is None:
                raise ConfigurationError(
                    f"Cannot write {path}: where the map lies on the earth is not known. Give the place of the poses' "
                    "world as --origin LAT,LON,ALT, or focus on a --dem GeoTIFF whose coordinates are those of the "
                    "poses."
                )

    def check_map(self, raster: MapRaster) -> None:
        """Refuse pictures of a map that is too large for them.

        Raises:
            ConfigurationError: naming the picture.
        """
        for path in self._pictures():
            if raster.rows * raster.columns > MAX_PICTURE_CELLS:
                raise ConfigurationError(
                    f"Cannot write {path}: a picture of {raster.columns} x {raster.rows} pixels is too large. Write a "
                    "GeoTIFF, or choose a coarser --ortho."
                )

    def write(
        self,
        rasters: SurveyRasters,
        bands: tuple[str, ...],
        place: MapPlace | None,
        significances: NDArray[np.float32] | None,
    ) -> None:
        """Write all files but the table and its pictures."""
        integral = rasters.integral
        write_raster(self.out, integral[:, :, 0] if len(bands) == 1 else integral, place, bands, np.nan)
        if self.count is not None:
            write_raster(self.count, rasters.coverage, place, ("images",), 0)
        if self.png is not None:
            write_picture(self.png, shade_integral(integral, bands))
        if significances is not None:
            self._write_anomalies(significances, rasters.coverage, place)
        if place is not None:
            for picture in self._pictures():
                write_world_file(picture, place.raster)

    def write_blobs(
        self, blobs: list[MapBlob], georeference: Georeference | None, pictures: Sequence[Path] = ()
    ) -> None:
        """Write the table, if there is one to write, with the names of its pictures."""
        if self.blobs is not None:
            folder = self.blobs.absolute().parent
            names = [Path(os.path.relpath(path.absolute(), folder)).as_posix() for path in pictures]
            text = encode_anomalies(blobs, georeference, self.blobs.suffix.lower(), names)
            with written_whole(self.blobs) as file:
                file.write(text.encode("utf-8"))

    def _geotiffs(self) -> list[Path]:
        paths = (self.out, self.count, *self.anomaly)
        return [path for path in paths if path is not None and path.suffix.lower() in TIFF_SUFFIXES]

    def _pictures(self) -> list[Path]:
        heat = [path for path in self.anomaly if path.suffix.lower() == ".png"]
        return heat if self.png is None else [self.png, *heat]

    def _write_anomalies(
        self, significances: NDArray[np.float32], coverage: NDArray[np.uint16], place: MapPlace | None
    ) -> None:
        for path in self.anomaly:
            if path.suffix.lower() == ".png":
                # What chance makes everywhere stays black.
                strong = np.where(significances > 2.0, np.rint(10.0 * significances), 0.0).astype(np.uint16)
                write_picture(path, shade_counts(strong, coverage > 0))
            else:
                write_raster(path, significances, place, ("significance",), None)
