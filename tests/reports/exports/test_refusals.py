"""What no export can write is refused in a sentence, before anything is written."""

import sys
from types import SimpleNamespace
from typing import Any

import pytest
import xarray as xr
from made_row import STREET as MADE
from made_row import made_row
from scenes import scene_text
from sentences import refusal
from streets_drawn import street_file

import pounding_risk as pr
from pounding_risk.reports import exports

STREET = (MADE[0], *MADE[4:])  # Corner, Kiosk, and Vault, which is rigid
NAMES = [one.name for one in STREET]
SHORT = {"window": ["0 s", "4 s"], "pga": "0.5 g"}
VAN_MIER = {"law": "van_mier", "restitution": None, "plastic_exponent": 1.2, "yield_force": "4 MN"}
FALLING = {"rule": "peak_oriented", "backbone": [[4.0, 1.2], [12.0, 0.1]]}
SOFT = {"name": "soft", "floor_masses": ["100 t"], "storey_stiffnesses": "90 MN/m", "storey_heights": "3 m"}
COLLAPSING = {
    "left": SOFT | {"storey_strengths": ["100 kN"], "hysteresis": FALLING},
    "right": SOFT | {"name": "firm"},
    "records": SHORT | {"pga": "1.5 g"},
    "effects": {"inelastic_storeys": {}, "p_delta": {}},
}
PGA = {"intensity": "pga"}
DEMANDS, AVERAGE = {"pga": "0.3 g"}, {"intensity": "sa_avg(0.5-1 s)"}
# What is exported, to which format, to which path, with which options.
REFUSED: dict[str, tuple[Any, ...]] = {
    "tables to a file": ("results", "csv", "taken", {}),
    "demands to a file": ("results", "pelicun", "taken", DEMANDS),
    "a row in two streets": ("row", "geopackage", "a.gpkg", {"street": "two.geojson"}),
    "a row without some footprints": ("row", "geopackage", "a.gpkg", {"street": "few.geojson"}),
    "a street without footprints": ("row", "geopackage", "a.gpkg", {"street": "walls.csv"}),
    "one building twice": ("two rows", "geopackage", "a.gpkg", {}),
    "yielding on a map": ("row", "geopackage", "a.gpkg", {"of": "yield"}),
    "an amplitude that was not run": ("row", "geopackage", "a.gpkg", {"pga": "0.3 g"}),
    "a map without its library": ("row", "geopackage", "a.gpkg", {}),
    "layers without their library": ("row", "geoparquet", "a", {}),
    "an intensity with a damping": ("results", "nrml", "f.xml", {"intensity": "sa(1 s, 2 %)"}),
    "one recording": ("one recording", "nrml", "f.xml", PGA),
    "a format misspelt": ("results", "nmrl", "f.xml", {}),
    "another suffix": ("results", "nrml", "f.txt", {}),
    "a fragility of something else": ("results", "nrml", "f.xml", {"of": "collapse"}),
    "contact without pounding": ("results", "nrml", "f.xml", {"without": True}),
    "a scene without damage": ("row", "nrml", "f.xml", {"of": "damage"}),
    "damage at one amplitude": ("results", "nrml", "f.xml", {"of": "damage", "pga": "0.3 g"}),
    "curves that are fitted": ("damaged", "nrml", "f.xml", PGA),
    "contact of curves": ("damaged", "nrml", "f.xml", {"of": "contact"}),
    "tables of curves": ("damaged", "csv", "tables", {}),
    "tables of histories": ("histories", "csv", "tables", {}),
    "two sources": ("two results", "nrml", "f.xml", {}),
    "a method of contact": ("results", "nrml", "f.xml", {"of": "contact", "method": "ida", **PGA}),
    "a method of curves": ("damaged", "nrml", "f.xml", {"method": "ida"}),
    "demands with a method of curves": ("damaged", "pelicun", "folder", {"method": "ida"}),
    "demands with curves that are fitted": ("damaged", "pelicun", "folder", PGA),
    "no curve at all": ("curves without a fit", "pelicun", "folder", {}),
    "demands of something else": ("results", "pelicun", "folder", {"of": "collapse", **DEMANDS}),
    "an intensity without a name elsewhere": ("results", "pelicun", "folder", AVERAGE | DEMANDS),
    "a law without a material": (VAN_MIER, "opensees", "model.py", {}),
    "a law that is unknown there": ({"law": "bilinear"}, "opensees", "model.py", {}),
    "an e that falls": ({"restitution": "concrete"}, "opensees", "model.py", {}),
    "an effect": ({"effects": {"permanent_set": {}}, "law": "viscous_elastoplastic"}, "opensees", "model.py", {}),
    "a storey that collapses": (COLLAPSING, "opensees", "model.py", {}),
    "results in place of a scene": ("results", "opensees", "model.py", {}),
    "a scene in place of results": ("scene.toml", "nrml", "f.xml", {}),
    "levels of a script": ({}, "opensees", "model.py", {"discrete": True}),
    "an inventory of others": ("row", "taxonomy", "t.csv", {"inventory": "assets.csv"}),
    "levels of a taxonomy": ("row", "taxonomy", "t.csv", {"discrete": True}),
    "an inventory beside tables": ("row", "csv", "t", {"inventory": "assets.csv"}),
}  # fmt: skip


@pytest.fixture(scope="module")
def sources(results, damaged) -> dict[str, Any]:
    """Datasets by name."""
    row, blow = made_row(records=3, gaps=(0.02,), street=STREET), damaged.sel(state=["blow"])
    return {
        "results": results,
        "damaged": damaged,
        "row": row,
        "two rows": [row, row],
        "two results": [results, results],
        "one recording": results.isel(pga=[1], record=[0], polarity=[0]),
        "curves without a fit": blow.assign_coords(fault=(("state", "pounding"), [["none is known"] * 2])),
        "histories": xr.Dataset({name: ("sample", [0.0]) for name in ("time", "displacement")}),
        "scene.toml": "scene.toml",
    }


def scene_of(left: Any = None, right: Any = None, **more: Any) -> Any:
    """A scene of the usual pair, or of two other buildings."""
    return pr.read_scene(scene_text(*([left, right] if left else []), **more))


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_exported_is_refused(case, sources, says, tmp_path, monkeypatch):
    source, to, path, options = REFUSED[case]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("kept")
    street_file(tmp_path / "two.geojson", [(street, name) for street in ("North", "South") for name in NAMES])
    street_file(tmp_path / "few.geojson", [("", name) for name in NAMES[:1]])
    (tmp_path / "walls.csv").write_text("name,height [m],storeys,floor area [m^2],gap [mm]\nCorner,9,3,100,10\n")
    (tmp_path / "assets.csv").write_text("id,lon,lat,taxonomy\nCorner 2,23.7,37.9,CR/LFM+CDL/H:2\n")
    if case.endswith(" library"):
        monkeypatch.setitem(sys.modules, "pyogrio", None)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    given = sources[source] if isinstance(source, str) else scene_of(**{"records": SHORT} | source)
    says(refusal(pr.export, given, to, path, **options))
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    "fact", [{"write": None}, {"SOURCE": "result"}, {"TAKES": ("gapp",)}], ids=lambda fact: next(iter(fact))
)
def test_a_format_that_nothing_could_be_written_with_is_refused(fact: dict[str, Any], says):
    """As a file of the package or as a plug-in: an option misspelt would never be taken."""
    facts = {"WORDS": "a text", "ENDINGS": (".txt",), "SOURCE": "results", "TAKES": ("gap",), "write": print, **fact}
    says(refusal(exports._checked, "text", SimpleNamespace(**{key: fact for key, fact in facts.items() if fact})))
