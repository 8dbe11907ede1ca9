"""What holds of every kind of scene: read back, screened, one run as in the scan, and a pair by either solver."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from scenes import BOTH, rigid, scene_text, single, storeyed
from sweeps import sweep
from test_simulate import CHOICES

import pounding_risk as pr
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.counters import COMPLETE

RECORDS = {"names": ["RSN6-180", "RSN6-270"], "window": ["1 s", "4 s"], "pga": "0.5 g", "polarity": BOTH}
GAPS = {"gap": ["0 mm", "10 mm", "1 m"]}
FORCES = {"yield_force": ["300 kN", "3 MN", "inf"]}
TWO_LAWS = {"contact_model": ["jankowski", "viscous_elastoplastic"]}
NO_FORCE = {"stiffness": None, "yield_force": "300 kN"}
WAVE = {"wave_passage": {"velocity": "400 m/s", "distance": "30 m"}}
YIELDING = {"permanent_set": {}, "unloading_stiffness": {"ratio": 1.5}}
YIELDING |= {"strain_rate": {"code": "mc2010", "length": "0.6 m"}}
MASSES = (
    single("left", "500 t", "0.5 s", floor_length="15 m"),
    single("right", "800 t", "0.31 s", floor_length="24 m"),
)
THREE = (*MASSES, single("last", "300 t", "0.4 s"))
MODELS = [
    {"gap": "10 mm", "contact_model": model, "stiffness": "2.75e9 N/m^1.5", "restitution": 0.6}
    for model in ("jankowski", "viscous_elastoplastic")
]
SLIPPING = {"link_stiffness": "20 MN/m", "link_strength": "60 kN"}
BUMPER = {"penetration": ["0 mm", "10 mm", "20 mm"], "force": ["0 kN", "100 kN", "600 kN"]}
BUMPER |= {"unloading": ["0 kN", "0 kN", "600 kN"]}
MOVING = {"initial_displacement": "-4 mm", "initial_velocity": "0.1 m/s"}


def kind(*buildings: Any, grid: Any = None, **keys: Any) -> str:
    """A scene of this kind, along gaps at least."""
    return scene_text(*(buildings or MASSES), records=RECORDS, grid=GAPS | (grid or {}), **keys)


# A scene, and the choice of a run that is not the scene's own.
SCENES: dict[str, tuple[str, dict[str, Any]]] = CHOICES | {
    "two laws": (kind(grid=FORCES | TWO_LAWS, restitution="concrete"), {"law": "jankowski"}),
    "no cap": (kind(grid=FORCES, law="linear", stiffness="5e8 N/m"), {"yield_force": 3e5}),
    "jumps": (
        kind(grid={"contact_model": ["merged", "stereomechanical"]}, law="merged", **NO_FORCE),
        {"law": "stereomechanical"},
    ),
    "colliding floors": (kind(law="distributed_mass", **NO_FORCE | {"restitution": None}), {}),
    "effects of yielding": (
        kind(grid=FORCES, law="viscous_elastoplastic", effects=YIELDING | WAVE),
        {"yield_force": 3e5},
    ),
    "a wave under jumps": (kind(law="merged", effects=WAVE, **NO_FORCE), {}),
    "several models": (kind(*THREE, interfaces=MODELS, grid=FORCES), {"yield_force": 3e5}),
    "a table": (kind(law="tabulated", table=BUMPER, **NO_FORCE | {"restitution": None}), {}),
    "moving at first": (
        kind(
            MASSES[0] | MOVING,
            MASSES[1] | {"initial_velocity": "-0.05 m/s"},
            grid=FORCES | {"contact_model": ["viscous_elastoplastic", "stereomechanical"]},
        ),
        {"law": "viscous_elastoplastic"},
    ),
    "links that slip": (kind(*THREE, law="linear", **SLIPPING), {}),
    "jumps in a row": (kind(*THREE, law="stereomechanical", **NO_FORCE), {}),
    "a row under a wave": (kind(storeyed("a", "70 t", "40 MN/m", storeys=3), rigid(height="9 m"), effects=WAVE), {}),
}
EVERY_RUN = {*CHOICES, "links that slip"}  # no case of theirs is known without a run of its own
LONG = ("wall under a wave", "jumps in a row", "a row under a wave")  # of which kernels are compiled


@pytest.fixture(scope="module", params=sweep(SCENES, *(name for name in SCENES if name not in LONG)))
def scanned(request):
    """The scene and its scan."""
    study = parse_scene(SCENES[request.param][0])
    return study, pr.scan(study, check_fraction=0.0, workers=1)


def test_it_is_read_back(scanned):
    study, _ = scanned
    assert scene_of(study.resolved()) == parse_scene(study.to_toml()) == study == study.updated(rtol=study.rtol)


def test_screening_leaves_no_trace(scanned, request):
    """Energy is closed over the buildings that have been solved together, which are more without."""
    study, found = scanned
    every = pr.scan(study, screening=False, check_fraction=0.0, workers=2)
    assert (found["status"] == COMPLETE).all() and every["simulated"].all()
    assert found["simulated"].all() == (request.node.callspec.params["scanned"] in EVERY_RUN)
    told = ["simulated", "energy_residual"] if study.is_row else ["simulated"]
    one, other = (each.drop_vars(told).assign_attrs(options="", parts="") for each in (found, every))
    xr.testing.assert_identical(one, other)


def test_a_run_is_that_of_the_scan(scanned, request):
    """Each output of the case, to the bit, with its unit, long name and type."""
    study, whole = scanned
    run = pr.simulate(study, **SCENES[request.node.callspec.params["scanned"]][1])
    place = {axis: run.attrs[axis] for axis in ("gap", "yield_force", "pga") if axis in whole.dims}
    case = whole.sel(place, method="nearest").sel(contact_model=run.attrs["contact_model"]).isel(record=0, polarity=0)
    outputs = [name for name in case.data_vars if not name.endswith("_free") and "period" not in case[name].dims]
    outputs = [name for name in outputs if name not in ("status", "simulated")]
    assert set(outputs) <= set(run.data_vars) and len(outputs) > 20
    for name in outputs:
        np.testing.assert_array_equal(run[name].values, case[name].values, err_msg=name)
        assert run[name].dtype == case[name].dtype, name
        assert run[name].attrs == {key: case[name].attrs[key] for key in ("units", "long_name")}, name
    assert run["impact_count"].values.max() > 0


ALIKE = ("peak_closing", "peak_opening", "peak_penetration", "peak_contact_force", "impulse", "contact_time")
ALIKE += ("impact_count", "yield_count", "permanent_set", "energy_plastic", "energy_viscous")
ALIKE += ("peak_displacement", "peak_storey_shear", "peak_floor_acceleration")


@pytest.mark.parametrize("name", ["two laws", "no cap", "jumps", "a table", "moving at first"])
def test_the_solver_of_rows_gives_a_pair_what_its_own_does(name):
    """They share laws and tableau, and neither flight nor events: a thousand times the tolerance of both.

    Corners of a table are stepped over, where an error of a step is of the first order: ten times that of other laws.
    """
    study = parse_scene(SCENES[name][0]).updated(rtol=1e-12)
    pair, row = (pr.scan(study.updated(is_row=is_row), check_fraction=0.0).isel(gap=1) for is_row in (False, True))
    assert pair["impact_count"].min() >= 2 and pair["impact_count"].sum() > 10
    for output in ALIKE:
        np.testing.assert_allclose(row[output], pair[output], rtol=1e-9, atol=1e-12, err_msg=output)
    np.testing.assert_allclose(row["first_impact_time"], pair["first_impact_time"], rtol=0.0, atol=1e-12)
