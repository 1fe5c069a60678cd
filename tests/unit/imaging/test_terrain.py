import gzip
from pathlib import Path

import cv2
import numpy as np
import pymap3d
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aos_gcs import extras
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.imaging.surfaces import mesh
from aos_gcs.imaging.surfaces.dem_files import read_dem
from aos_gcs.imaging.surfaces.mesh import terrain_from_mesh
from aos_gcs.imaging.surfaces.terrain import Terrain

ORIGIN = GeodeticPosition(48.0, 14.0, 500.0)


def hills(spacing_m: float = 0.5, size: int = 121) -> Terrain:
    rows, columns = np.mgrid[0:size, 0:size] * spacing_m
    heights = 3 * np.sin(columns / 6) + 2 * np.cos(rows / 5)
    return Terrain(-spacing_m * (size - 1) / 2, -spacing_m * (size - 1) / 2, spacing_m, heights)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), x=st.floats(-10, 10), y=st.floats(-10, 10), above=st.sampled_from([40.0, -40.0]))
def test_rays_end_on_the_terrain(seed: int, x: float, y: float, above: float) -> None:
    terrain, rng = hills(), np.random.default_rng(seed)
    rays = np.column_stack((rng.uniform(-0.4, 0.4, (200, 2)), np.full(200, -np.sign(above))))
    points = terrain.intersect([x, y, above], rays)
    hit = np.isfinite(points).all(axis=1)
    np.testing.assert_allclose(terrain.z_m(points[hit, 0], points[hit, 1]), points[hit, 2], atol=1e-6)
    along = (points[hit] - [x, y, above]) / rays[hit]
    np.testing.assert_allclose(along[:, 2:], along[:, :1], rtol=1e-9, atol=1e-9)
    # Rays that miss have left the terrain at its sides before they came down.
    feet = np.array([x, y]) + rays[~hit, :2] * (abs(above) - 5.0)
    assert (np.abs(feet).max(axis=1) > 22.0).all()


def test_the_nearer_of_two_slopes_is_hit() -> None:
    x = np.linspace(-10, 10, 201)
    ridge = Terrain(-10.0, -10.0, 0.1, np.tile(np.where(np.abs(x) < 1.0, 6.0, 0.0), (201, 1)))
    points = ridge.intersect([-10.0, 0.0, 10.0], np.array([[1.0, 0.0, -0.6], [1.0, 0.0, -1.2]]))
    np.testing.assert_allclose(points[0], [-0.924, 0.0, 4.554], atol=1e-3)
    np.testing.assert_allclose(points[1], [-10 + 10 / 1.2, 0.0, 0.0], atol=1e-6)


def test_rays_upwards_beside_and_without_direction_miss() -> None:
    rays = np.array([[0, 0, 1.0], [1, 0, 0], [0.9, 0, -0.1], [np.nan, 0, -1], [0, 0, -1]])
    points = hills().intersect([0.0, 0.0, 40.0], rays)
    np.testing.assert_array_equal(np.isfinite(points[:, 2]), [False, False, False, False, True])


def test_holes_and_the_outside_have_no_height() -> None:
    terrain = hills()
    terrain.heights_m[60, 60] = np.nan
    assert np.isnan(terrain.z_m([0.1, 40.0, 0.0], [0.1, 0.0, -31.0])).all()
    assert np.isnan(terrain.intersect([0.1, 0.1, 40.0], np.array([[0.0, 0.0, -1.0]]))).all()
    assert np.isfinite(terrain.z_m([-30.0, 30.0], [30.0, -30.0])).all()
    assert terrain.moved(3.0).z_m(5.0, 5.0) == pytest.approx(terrain.z_m(5.0, 5.0) + 3.0)


def grid_mesh(size: int, seed: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return a square of 2 size² triangles with random heights."""
    rows, columns = np.mgrid[0 : size + 1, 0 : size + 1]
    z = np.random.default_rng(seed).uniform(0, 3, rows.size)
    index = np.arange(rows.size).reshape(rows.shape)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel()
    # Both orders of rotation.
    triangles = np.concatenate((np.stack((a, b, c), axis=1), np.stack((b, c, d), axis=1)))
    return np.column_stack((columns.ravel() * 2.0 - 5.0, rows.ravel() * 2.0 + 7.0, z)), triangles


@pytest.mark.parametrize("spacing_m", [0.25, 0.37])
def test_a_mesh_keeps_its_heights(spacing_m: float) -> None:
    vertices, triangles = grid_mesh(6, 1)
    terrain = terrain_from_mesh(vertices, triangles, spacing_m)
    rows, columns = np.mgrid[0 : terrain.heights_m.shape[0], 0 : terrain.heights_m.shape[1]]
    x, y = (columns * spacing_m) / 2.0, (rows * spacing_m) / 2.0
    i, j = np.minimum(x.astype(int), 5), np.minimum(y.astype(int), 5)
    u, v = x - i, y - j
    z = vertices[:, 2].reshape(7, 7)
    a, b, c, d = z[j, i], z[j, i + 1], z[j + 1, i], z[j + 1, i + 1]
    expected = np.where(u + v <= 1, a + u * (b - a) + v * (c - a), d + (1 - u) * (c - d) + (1 - v) * (b - d))
    np.testing.assert_allclose(terrain.heights_m, expected, atol=1e-9)
    assert (terrain.x_m, terrain.y_m) == (-5.0, 7.0)


def test_where_a_mesh_has_no_triangle_the_height_is_unknown() -> None:
    vertices, triangles = grid_mesh(4, 2)
    terrain = terrain_from_mesh(vertices, np.delete(triangles, [0, 16], axis=0), 0.1)
    assert np.isnan(terrain.z_m(-4.5, 7.5))
    assert np.isnan(terrain.z_m(-3.5, 8.5))
    assert np.isfinite(terrain.z_m(-2.5, 8.5))


OBJ = "# a square\no dem\nv 0 0 1\nv 10 0 1\nv 10 10 3\nv 0 10 3\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"


@pytest.mark.parametrize("faces", ["f 1/1/1 2/2/1 3/3/1 4/4/1", "f -4 -3 -2\nf -4 -2 -1", "f 1//1 2//1 3//1\nf 1 3 4"])
def test_obj_files(tmp_path: Path, faces: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh, "DEFAULT_SAMPLES", 10_000)
    text = "# a square\no dem\nv 0 0 1\nv 10 0 1\nv 10 10 3\nv 0 10 3\nvn 0 0 1\n" + faces + "\n"
    plain, packed = tmp_path / "dem.obj", tmp_path / "dem.obj.gz"
    plain.write_text(text)
    packed.write_bytes(gzip.compress(text.encode()))
    for path in (plain, packed):
        assert read_dem(path).z_m(4.0, 5.0) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("dem.obj", b"v 0 0 zero\n", "invalid line 1: 'v 0 0 zero'"),
        ("dem.obj", b"v 0 0 0\nf 0 1 2\n", "invalid line 2"),
        ("dem.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "not a mesh of finite vertices"),
        ("dem.obj", b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", "not a mesh of finite vertices"),
        ("dem.obj", b"", "not a mesh of finite vertices"),
        ("dem.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no horizontal extent"),
        ("dem.obj.gz", b"not gzip", "cannot be read"),
        ("dem.obj.gz", gzip.compress(OBJ.encode(), mtime=0)[:-20], "cannot be read"),
    ],
)
def test_bad_meshes_are_named(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(InputDataError, match=rf"The terrain .*{name} .*{message}"):
        read_dem(path)


def test_bad_requests_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputDataError, match=r"absent\.obj does not exist; check the path"):
        read_dem(tmp_path / "absent.obj")
    with pytest.raises(ConfigurationError, match=r"dem\.las is of no known kind: use \.obj"):
        read_dem(tmp_path / "dem.las")
    with pytest.raises(ConfigurationError, match="mesh without a coordinate system"):
        read_dem(tmp_path / "dem.obj", ORIGIN)

    def absent(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(extras.importlib, "import_module", absent)
    with pytest.raises(ConfigurationError, match=r"needs rasterio.*pip install 'aos-gcs\[geo\]'"):
        read_dem(tmp_path / "dem.tif")


@pytest.mark.parametrize(("heights", "spacing_m"), [(np.zeros((1, 5)), 1.0), (np.zeros((3, 3)), 0.0)])
def test_a_terrain_needs_an_extent(heights: NDArray[np.float64], spacing_m: float) -> None:
    with pytest.raises(ValueError, match="terrain"):
        Terrain(0.0, 0.0, spacing_m, heights)
    with pytest.raises(ValueError, match="known height"):
        Terrain(0.0, 0.0, 1.0, np.full((2, 2), np.nan))


def write_geotiff(
    path: Path,
    heights: NDArray[np.float32],
    transform: tuple[float, ...],
    crs: str | None = None,
    nodata: float | None = -9999.0,
) -> None:
    rasterio = pytest.importorskip("rasterio", reason="rasterio (the extra 'geo') is not installed")
    rows, columns = heights.shape
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=columns,
        height=rows,
        count=1,
        dtype="float32",
        transform=rasterio.Affine(*transform),
        crs=crs,
        nodata=nodata,
    ) as dataset:
        dataset.write(heights, 1)


def test_geotiff_in_coordinates_of_its_own(tmp_path: Path) -> None:
    heights = np.add.outer(np.arange(20.0) * -2.0, np.arange(30.0)).astype(np.float32)
    heights[0, 0] = -9999.0
    path = tmp_path / "dem.tif"
    write_geotiff(path, heights, (0.5, 0.0, 100.0, 0.0, -0.5, 50.0))
    terrain = read_dem(path)
    # Pixel (row 4, column 6) has its centre at x = 100 + 3.25, y = 50 - 2.25.
    assert terrain.z_m(103.25, 47.75) == pytest.approx(-2.0)
    assert terrain.z_m(103.5, 47.75) == pytest.approx(-1.5)
    assert np.isnan(terrain.z_m(100.25, 49.75))
    assert terrain.z_m(114.75, 40.25) == pytest.approx(-9.0)


@pytest.mark.parametrize("crs", ["EPSG:32633", "EPSG:4326"])
def test_geotiff_about_an_origin(tmp_path: Path, crs: str) -> None:
    pyproj = pytest.importorskip("pyproj", reason="pyproj (the extra 'geo') is not installed")
    project = pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True)
    x0, y0 = project.transform(ORIGIN.longitude_deg, ORIGIN.latitude_deg)
    step = 1.0 if crs == "EPSG:32633" else 1e-5
    rows, columns = np.mgrid[0:200, 0:200]
    to_geodetic = pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    longitude, latitude = to_geodetic.transform(x0 + (columns - 99.5) * step, y0 - (rows - 99.5) * step)
    east, north, _ = pymap3d.geodetic2enu(latitude, longitude, 500.0, 48.0, 14.0, 500.0)
    path = tmp_path / "dem.tif"
    heights = (520.0 + 0.1 * east - 0.05 * north).astype(np.float32)
    write_geotiff(path, heights, (step, 0.0, x0 - 100 * step, 0.0, -step, y0 + 100 * step), crs)
    terrain = read_dem(path, ORIGIN)
    for x, y in ((0.0, 0.0), (30.0, -20.0), (-40.0, 35.0)):
        assert terrain.z_m(x, y) == pytest.approx(20.0 + 0.1 * x - 0.05 * y, abs=0.01)


@pytest.mark.parametrize("turns", [-1, 0, 1])
@pytest.mark.parametrize("origin_deg", [179.9999, -179.9999])
def test_terrain_in_degrees_across_the_180th_meridian_is_whole(tmp_path: Path, turns: int, origin_deg: float) -> None:
    step, rows, columns = 1e-5, *np.mgrid[0:200, 0:200]
    path = tmp_path / "dem.tif"
    heights = (20.0 + 0.02 * (columns - 99.5) - 0.03 * (rows - 99.5)).astype(np.float32)
    west_deg, north_deg = 180.0 + 360.0 * turns - 100 * step, -17.0 + 100 * step
    write_geotiff(path, heights, (step, 0.0, west_deg, 0.0, -step, north_deg), "EPSG:4326")
    terrain = read_dem(path, GeodeticPosition(-17.0, origin_deg, 0.0))
    for column, row in ((10, 100), (99, 99), (100, 150), (190, 20)):
        latitude_deg, longitude_deg = north_deg - (row + 0.5) * step, west_deg + (column + 0.5) * step
        east_m, north_m, _ = pymap3d.geodetic2enu(latitude_deg, longitude_deg, 20.0, -17.0, origin_deg, 0.0)
        assert terrain.z_m(east_m, north_m) == pytest.approx(heights[row, column], abs=0.01)
    assert np.isfinite(terrain.heights_m).mean() > 0.98


@pytest.mark.parametrize(
    ("height_m", "message"),
    [(-9999.0, r"has heights of -9999 m: declare them as holes \(gdal_edit -a_nodata -9999\)"), (29000.0, "in feet")],
)
def test_geotiffs_with_heights_of_no_place_on_earth_are_refused(tmp_path: Path, height_m: float, message: str) -> None:
    heights = np.full((20, 20), 600.0, dtype=np.float32)
    heights[3:5, 7:9] = height_m
    path = tmp_path / "dem.tif"
    write_geotiff(path, heights, (1.0, 0.0, 5.0, 0.0, -1.0, 9.0), nodata=None)
    with pytest.raises(InputDataError, match=f"The terrain .*{message}"):
        read_dem(path)


def test_geotiffs_that_cannot_be_placed_are_refused(tmp_path: Path) -> None:
    heights = np.zeros((4, 4), dtype=np.float32)
    names = "bare", "degrees", "empty", "broken", "picture"
    bare, degrees, empty, broken, picture = (tmp_path / f"{name}.tif" for name in names)
    write_geotiff(bare, heights, (1.0, 0.0, 5.0, 0.0, -1.0, 9.0))
    write_geotiff(degrees, heights, (1e-4, 0.0, 14.0, 0.0, -1e-4, 48.0), "EPSG:4326")
    write_geotiff(empty, heights - 9999.0, (1.0, 0.0, 5.0, 0.0, -1.0, 9.0))
    cv2.imwrite(str(picture), heights)
    broken.write_bytes(b"II*\0 and no more")
    with pytest.raises(InputDataError, match=r"bare\.tif has no coordinate system"):
        read_dem(bare, ORIGIN)
    with pytest.raises(InputDataError, match=r"degrees\.tif is in degrees \(EPSG:4326\)"):
        read_dem(degrees)
    with pytest.raises(InputDataError, match=r"empty\.tif cannot be used: a terrain needs at least one known"):
        read_dem(empty)
    with pytest.raises(InputDataError, match=r"picture\.tif has no georeference"):
        read_dem(picture)
    with pytest.raises(InputDataError, match=r"broken\.tif cannot be read"):
        read_dem(broken)
