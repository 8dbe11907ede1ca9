"""Layers of maps: numbers are those of the runs, shapes those of the street, and files what their readers want."""

import sqlite3
from contextlib import closing
from itertools import pairwise
from xml.etree import ElementTree as Xml

import geopandas
import numpy as np
import pyogrio
import pyproj
import pytest
from made_row import STREET as MADE
from made_row import made_row
from scenes import scene_text, single, storeyed
from scipy import stats
from shapely import box
from streets_drawn import DEEP, EAST, NORTH, WIDE, corner, street_file

import pounding_risk as pr
from pounding_risk.assessment.row import row_case
from pounding_risk.errors import PoundingError
from pounding_risk.figures.row import plan_figure
from pounding_risk.reports.exports import geopackage
from pounding_risk.reports.exports._layers import BUILDING, INTERFACE
from pounding_risk.reports.exports._outlines import REACH, face_of
from pounding_risk.reports.exports._styles import CLASSES
from pounding_risk.results.opened import Results

STREET = (MADE[0], *MADE[4:])  # Corner, Kiosk, and Vault, which is rigid
ROW = {"records": 3, "gaps": (0.02,), "street": STREET}


@pytest.fixture(scope="module")
def row():
    return made_row(**ROW)


@pytest.fixture(scope="module")
def street(tmp_path_factory):
    """Footprints of the made row, and of a building in none."""
    names = [*(one.name for one in STREET), "Lone"]
    return street_file(tmp_path_factory.mktemp("street") / "street.geojson", [("", name) for name in names])


@pytest.fixture(scope="module")
def mapped(row, street, tmp_path_factory):
    """The layers with footprints: the file, and what was told."""
    return pr.export(row, "geopackage", tmp_path_factory.mktemp("map") / "street.gpkg", street=street)


def test_shares_of_buildings_are_counts_of_their_runs(row, mapped):
    buildings = geopandas.read_file(mapped.files[0], layer="buildings")
    assert list(buildings["building"]) == [one.name for one in STREET]
    own = row.sel(gap=0.02, pga=0.4 * 9.80665, method="nearest").isel(contact_model=0, yield_force=0)
    verdicts = [one.verdict for one in pr.assess(row).interfaces]
    for at, building in enumerate(buildings.itertuples()):
        beside = [k for k in (at - 1, at) if 0 <= k < len(STREET) - 1]
        struck = (own["impact_count"].isel(interface=beside) > 0).any("interface").values.ravel()
        reached = (own["yield_exceedance"].isel(interface=beside) > 0).any("interface").values.ravel()
        assert (building.p_contact, building.p_yield) == pytest.approx((struck.mean(), reached.mean()), rel=1e-12)
        weight = min(verdicts[k].independent / verdicts[k].motions for k in beside)
        count, runs = weight * struck.sum(), weight * struck.size
        low = stats.beta.ppf(0.025, count, runs - count + 1) if count else 0.0
        high = stats.beta.ppf(0.975, count + 1, runs - count) if struck.sum() < struck.size else 1.0
        assert (building.p_contact_low, building.p_contact_high) == pytest.approx((low, high), rel=1e-9)
        words = [verdicts[k].word for k in beside]
        assert building.verdict == next(word for word in ("inadequate", "depends", "adequate") if word in words)
        for column, name in (("drift", "peak_drift"), ("acceleration", "peak_floor_acceleration")):
            both = [own[f"{name}{ending}"].isel(building=at).values.ravel()[struck] for ending in ("", "_free")]
            ratio = getattr(building, f"{column}_amplification")
            if struck.any() and np.isfinite(both).all() and STREET[at].storeys:
                assert ratio == pytest.approx(np.median(both[0] / both[1]), rel=1e-12)
            else:
                assert np.isnan(ratio)


def test_interfaces_have_what_assess_says(row, mapped):
    interfaces = geopandas.read_file(mapped.files[0], layer="interfaces")
    assert len(interfaces) == len(STREET) - 1
    for found, one in zip(interfaces.itertuples(), pr.assess(row).interfaces, strict=True):
        contact = one.contact_at_gap()
        assert (found.left, found.right, found.verdict) == (*one.name.split(" | "), one.verdict.word)
        assert (found.gap_m, found.p_contact) == (one.gap, contact.probability)
        assert (found.p_contact_low, found.p_contact_high) == (contact.low_recordings, contact.high_recordings)
        assert found.required_gap_p84_m == pytest.approx(
            np.percentile(one.closing, 84.0, method="inverted_cdf"), rel=1e-12
        )
        assert found.required_gap_p84_low_m == one.required_at(84.0).low
        assert np.isnan(found.required_gap_p95_high_m) and not one.required_at(95.0).bounded


def test_shapes_are_the_footprints_and_the_faces_between(mapped):
    buildings, interfaces = (geopandas.read_file(mapped.files[0], layer=layer) for layer in ("buildings", "interfaces"))
    assert buildings.crs == interfaces.crs == pyproj.CRS("EPSG:4326")
    for at, shape in enumerate(buildings.geometry):
        x, y = corner(at)
        assert shape.symmetric_difference(box(x, y, x + WIDE, y + DEEP)).area < 1e-9 * WIDE * DEEP
    geod = pyproj.Geod(ellps="WGS84")
    metre = 1.0 / geod.line_length([EAST, EAST], [NORTH, NORTH + 1.0])  # degrees of latitude
    for at, face in enumerate(interfaces.geometry):
        x, y = corner(at)
        west, south, east, north = face.bounds
        common = max(y, corner(at + 1)[1]), min(y, corner(at + 1)[1]) + DEEP
        # The wall, as far as the other building is within reach of it, and stubs along the walls that end there.
        assert east == pytest.approx(x + WIDE, abs=1e-12)
        assert south == pytest.approx(max(y, common[0] - REACH * metre), abs=0.1 * metre)
        assert north == pytest.approx(min(y + DEEP, common[1] + REACH * metre), abs=0.1 * metre)
        assert geod.line_length([west, east], [south, south]) < 1.1 * REACH
    assert any("1 footprint of it without a building" in sentence for sentence in mapped.notes)


@pytest.mark.parametrize("apart", [0.0, 0.1, -0.2])
def test_the_length_of_a_face_in_closed_form(apart):
    """Equal squares of 10 m: the wall between them, and stubs where the walls beside it are within reach."""
    face = face_of(box(0, 0, 10, 10), box(10 + apart, 0, 20, 10), is_degrees=False)
    # The nearest point is at 0 where they overlap; all of the overlap's outline is then within reach.
    stubs = 2.0 * (REACH - min(apart, 0.0))
    assert face.length == pytest.approx(10.0 + stubs, rel=1e-9)


def test_at_a_gap_without_runs_contact_is_known_and_the_rest_is_empty(row, tmp_path):
    closing = row["peak_closing_free"].sel(pga=0.4 * 9.80665, method="nearest").transpose("interface", ...)
    gap = float(closing.median())
    written = pr.export(row, "geoparquet", tmp_path / "layers", gap=gap)
    buildings, interfaces = (geopandas.read_parquet(file) for file in written.files)
    closes = closing.values.reshape(len(STREET) - 1, -1) > gap
    assert 0.0 < closes.mean() < 1.0
    assert list(interfaces["p_contact"]) == pytest.approx(closes.mean(axis=1), rel=1e-12)
    either = [closes[max(at - 1, 0) : at + 1].any(axis=0).mean() for at in range(len(STREET))]
    assert list(buildings["p_contact"]) == pytest.approx(either, rel=1e-12)
    assert interfaces[["p_yield", "impacts", "peak_force_N"]].isna().all(axis=None)
    assert buildings[["p_yield", "drift_amplification", "acceleration_amplification"]].isna().all(axis=None)
    assert any("the nearest are at 20 mm: yielding, impacts" in sentence for sentence in written.notes)


@pytest.mark.complete
def test_without_footprints_places_are_nominal_and_so_told(row, tmp_path):
    other = made_row(**ROW, seed=3)
    other.attrs["title"] = "Another street"
    written = pr.export([row, other], "geopackage", tmp_path / "rows.gpkg")
    assert any(sentence.startswith("not georeferenced") for sentence in written.notes)
    assert pyogrio.list_layers(written.files[0]).tolist() == [
        ["buildings", "Point"],
        ["interfaces", "MultiLineString"],
        ["layer_styles", None],
    ]
    buildings = geopandas.read_file(written.files[0], layer="buildings")
    assert list(buildings.groupby("row").size()) == [len(STREET)] * 2
    assert list(buildings.geometry.x) == [10.0 * at for at in range(len(STREET))] * 2
    assert buildings.geometry.y.nunique() == 2
    with closing(sqlite3.connect(written.files[0])) as file:
        assert file.execute("SELECT DISTINCT srs_id FROM gpkg_geometry_columns").fetchall() == [(-1,)]
        (words,) = file.execute("SELECT description FROM gpkg_contents WHERE table_name = 'buildings'").fetchone()
    assert words.startswith("not georeferenced")


def test_a_pair_of_single_masses_is_a_row_too(tmp_path):
    pair = single("frame", "100 t", "0.8 s", height="6 m"), single("wall", "200 t", "0.3 s")
    results = pr.scan(pr.read_scene(scene_text(*pair, gap="10 mm", records={"window": ["0 s", "6 s"]})))
    written = pr.export(results, "geoparquet", tmp_path / "layers")
    buildings, interfaces = (geopandas.read_parquet(file) for file in written.files)
    assert list(buildings["height_m"].isna()) == [False, True]
    struck = results["peak_displacement"].values.ravel() / results["peak_displacement_free"].values.ravel()
    assert list(buildings["drift_amplification"]) == pytest.approx(struck, rel=1e-12)
    assert (
        interfaces[["p_yield", "yield_force_N"]].isna().all(axis=None)
    )  # without F_E there is no share that reaches it


def test_columns_say_their_units(mapped, row, street, tmp_path):
    for name, column in (BUILDING | INTERFACE).items():
        assert name.endswith(f"_{column.unit}") == (column.unit not in ("", "1")), name
    with closing(sqlite3.connect(mapped.files[0])) as file:
        assert file.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert file.execute("PRAGMA foreign_key_check").fetchall() == []
        unknown = file.execute("SELECT building FROM buildings WHERE height_m IS NULL").fetchall()
        assert unknown == [("Vault",)]
        said = file.execute("SELECT table_name, column_name, description FROM gpkg_data_columns").fetchall()
        extension = "SELECT extension_name FROM gpkg_extensions WHERE table_name = 'gpkg_data_columns'"
        assert file.execute(extension).fetchall() == [("gpkg_schema",)]
        for layer, columns in (("buildings", BUILDING), ("interfaces", INTERFACE)):
            assert {name for table, name, _ in said if table == layer} == set(columns)
            known = {column for _, column, *_ in file.execute(f"PRAGMA table_info({layer})")}
            assert known == {"fid", "geom", *columns}
    assert ("interfaces", "gap_m", "assessed gap [m]") in said
    from pyarrow import parquet

    written = pr.export(row, "geoparquet", tmp_path / "layers", street=street)
    for file, layer, columns in zip(written.files, ("buildings", "interfaces"), (BUILDING, INTERFACE), strict=True):
        schema = parquet.read_schema(file)
        for name, column in columns.items():
            about = {"long_name": column.words} | ({"units": column.unit} if column.unit else {})
            assert {key.decode(): value.decode() for key, value in schema.field(name).metadata.items()} == about
        packed, whole = geopandas.read_parquet(file), geopandas.read_file(mapped.files[0], layer=layer)
        assert packed.crs == whole.crs
        plain = [frame.drop(columns="geometry").astype(object) for frame in (packed, whole)]
        plain = [frame.where(frame.notna(), "") for frame in plain]
        assert plain[0].equals(plain[1])


def test_qgis_finds_a_style_for_each_layer(mapped):
    """The table and what QGIS asks it for (QgsOgrProviderMetadata::loadStyle), and one rule for any probability."""
    styles = pyogrio.read_dataframe(mapped.files[0], layer="layer_styles", fid_as_index=True)
    assert list(styles) == [
        *("f_table_catalog", "f_table_schema", "f_table_name", "f_geometry_column", "styleName", "styleQML"),
        *("styleSLD", "useAsDefault", "description", "owner", "ui", "update_time"),
    ]
    assert pyogrio.read_info(mapped.files[0], layer="layer_styles")["fid_column"] == "id"
    for layer, kind in (("buildings", "fill"), ("interfaces", "line")):
        asked = (styles["f_table_schema"] == "") & (styles["f_table_name"] == layer) & styles["useAsDefault"]
        (one,) = styles[asked].itertuples()
        assert one.f_geometry_column == pyogrio.read_info(mapped.files[0], layer=layer)["geometry_name"]
        root = Xml.fromstring(one.styleQML)
        rules, symbols = root.findall(".//rule"), root.findall(".//symbol")
        assert {symbol.get("type") for symbol in symbols} == {kind}
        assert [rule.get("symbol") for rule in rules] == [symbol.get("name") for symbol in symbols]
        assert rules[-1].get("filter") == "ELSE"
        with closing(sqlite3.connect(":memory:")) as engine:  # the filters are SQL as well
            for share in (0.0, 1e-9, 0.16, 0.161, 0.5, 0.7, 0.84, 0.85, 1.0, None):
                hits = [
                    engine.execute(f'SELECT {rule.get("filter")} FROM (SELECT ? AS "p_contact")', (share,)).fetchone()
                    for rule in rules[:-1]
                ]
                assert sum(hit[0] or 0 for hit in hits) == (0 if share is None else 1)


def test_classes_grow_darker_with_the_probability():
    """Relative luminance (WCAG 2): contrast of one class with the next, so that colours are not needed."""
    levels = []
    for one in CLASSES[:-1]:
        channels = [int(one.colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
        levels.append(float(np.dot([0.2126, 0.7152, 0.0722], linear)))
    ratios = [(light + 0.05) / (dark + 0.05) for light, dark in pairwise(levels)]
    assert min(ratios) > 1.2 and min(ratios[1:]) > 1.6


def test_a_file_is_whole_or_as_it_was(row, tmp_path, monkeypatch):
    file = tmp_path / "street.gpkg"
    pr.export(row, "geopackage", file)
    before = file.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(geopackage, "style", full)
    with pytest.raises(PoundingError, match=r"street\.gpkg: cannot be written \(No space left on device"):
        pr.export(row, "geopackage", file)
    assert file.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["street.gpkg"]


def test_a_row_is_found_in_its_own_street(row, tmp_path):
    """Two streets with the same names: the title says which."""
    names = [one.name for one in STREET]
    twice = street_file(tmp_path / "two.geojson", [(street, name) for street in ("North", "South") for name in names])
    titled = row.assign_attrs(title="South, row 1")
    written = pr.export(titled, "geopackage", tmp_path / "a.gpkg", street=twice)
    first = geopandas.read_file(written.files[0], layer="buildings").geometry.iloc[0]
    assert first.bounds[0] == pytest.approx(corner(len(names))[0], abs=1e-12)


def test_each_interface_has_the_yield_force_of_its_own_contacts(tmp_path):
    """Of floors, and of columns where these alone are met; in the assessment, the layers and the fragilities alike."""
    contact = {"contact_model": "viscous_elastoplastic", "stiffness": "2e11 N/m^1.5", "restitution": 0.65}
    forces = [{"yield_force": "900 kN"}, {"yield_force": "400 kN"}, {"column_yield_force": "150 kN"}]
    results = pr.scan(
        scene_text(
            single("a", "150 t", "0.4 s", height="3 m"),
            single("b", "300 t", "0.9 s", height="3 m"),
            storeyed("c", "100 t", "90 MN/m", "3 m", storeys=2, damping=0.05),
            storeyed("d", "100 t", "40 MN/m", "4.4 m", storeys=1, damping=0.05),
            records={"names": ["RSN6-180", "RSN753-000"], "window": ["0 s", "10 s"], "pga": "0.6 g"},
            interfaces=[{"gap": "10 mm"} | contact | force for force in forces],
        )
    )
    peaks = results["peak_contact_force"].max(["record", "polarity"]).values.ravel()
    own = [9e5, 4e5, 1.5e5]
    # A contact that yields holds its F_E.
    np.testing.assert_allclose(peaks, own, rtol=1e-6)
    assessed = pr.assess(results).interfaces
    assert [one.own_force for one in assessed] == own
    assert [{share.yield_force for share in one.yielding} for one in assessed] == [{force} for force in own]
    pr.export(results, "geopackage", tmp_path / "row.gpkg")
    with sqlite3.connect(tmp_path / "row.gpkg") as connection:
        found = connection.execute("select yield_force_N, p_yield from interfaces").fetchall()
    assert [force for force, _ in found] == own
    assert all(share > 0.0 for _, share in found)


def test_a_building_yields_as_its_gaps_do(tmp_path):
    """Columns alone have an F_E in the first gap, nothing in the second: in the layers and in the plan."""
    contact = {"contact_model": "jankowski", "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}
    frames = zip("abc", ("3 m", "3.4 m", "3.1 m"), strict=True)
    text = scene_text(
        *(storeyed(name, "100 t", "90 MN/m", height, storeys=3, floor_depth="0.5 m") for name, height in frames),
        records={"names": ["RSN6-180", "RSN753-000"], "window": ["0 s", "10 s"], "pga": "0.6 g"},
        interfaces=[{"gap": "1 mm", **contact, **own} for own in ({"column_yield_force": "1 kN"}, {})],
    )
    results = pr.scan(text)
    assert {"floor", "column"} <= set(results["contact_point_kind"].values.tolist())
    pr.export(results, "geopackage", tmp_path / "row.gpkg")
    with sqlite3.connect(tmp_path / "row.gpkg") as connection:
        assert connection.execute("select p_yield from interfaces").fetchall() == [(1.0,), (None,)]
        assert connection.execute("select p_yield from buildings").fetchall() == [(1.0,), (1.0,), (None,)]
    (drawn,) = (each for each in plan_figure(row_case(results)).axes[1].collections if each.get_array() is not None)
    assert drawn.get_array().tolist() == [1.0, 1.0, None]


def test_along_an_axis_of_a_yield_force_each_place_has_its_own():
    contact = {"contact_model": "linear", "stiffness": "100 MN/m", "gap": "10 mm"}
    masses = (single(name, "150 t", period) for name, period in (("a", "0.4 s"), ("b", "0.9 s"), ("c", "0.5 s")))
    results = pr.scan(
        scene_text(
            *masses,
            records={"names": ["RSN6-180"], "window": ["0 s", "6 s"]},
            interfaces=[contact | {"yield_force": "900 kN"}, contact | {"yield_force": "400 kN"}],
            grid={"interface.2.yield_force": ["300 kN", "600 kN"]},
        )
    )
    assert [part.dataset["yield_force"].values.tolist() for _, part in Results(results).interfaces] == [[9e5], [9e5]]
    for place, force in enumerate((3e5, 6e5)):
        one = pr.assess(results.isel({"interface.2.yield_force": place}))
        assert [each.own_force for each in one.interfaces] == [9e5, force]
