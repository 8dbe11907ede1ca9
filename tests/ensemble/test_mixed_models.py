"""A row whose interfaces have contact models of their own: limits that equal rows of one model, and what is counted."""

from __future__ import annotations

import numpy as np
import pytest

import pounding_risk as pr
from pounding_risk.scene.scene import OF_EACH_INTERFACE

MODELS = ("jankowski", "viscous_elastoplastic")  # without a cap, and with one
FAR = 10.0  # m, never closed


def scene(gaps: tuple[float, float], models: tuple[str, str] = MODELS) -> pr.Scene:
    """Three masses, and what stands between them."""
    return pr.Scene(
        [pr.SingleMass("A", 2e5, 0.5), pr.SingleMass("B", 1e5, 0.21), pr.SingleMass("C", 3e5, 0.33)],
        [
            pr.Interface(gap, model, "2.75e9 N/m^1.5", restitution=0.6, yield_force=force)
            for gap, model, force in zip(gaps, models, (8e5, 5e5), strict=True)
        ],
        pr.Records(["RSN6-180"], window=[0.0, "5 s"], pga="0.4 g"),
    )


def scanned(one: pr.Scene, **options):
    return one.scan(check_fraction=0.0, **options)


@pytest.mark.parametrize("place", [0, 1])
def test_where_one_interface_never_closes_it_is_a_row_of_the_other_model(place):
    gaps = (0.01, FAR) if place == 0 else (FAR, 0.01)
    mixed, alone = scanned(scene(gaps)), scanned(scene(gaps, (MODELS[place],) * 2))
    assert mixed["contact_model"].values.tolist() == [OF_EACH_INTERFACE]
    assert mixed["interface_contact_model"].values.tolist() == list(MODELS)
    assert int(mixed["impact_count"].sum()) > 0
    for name in mixed.data_vars:
        assert mixed[name].values.tobytes() == alone[name].values.tobytes(), name


def test_both_touch_and_screened_runs_are_the_same():
    row = scene((0.005, 0.005)).replace(yield_force=["300 kN", "700 kN", "inf"])
    some, every = scanned(row), scanned(row, screening=False)
    counts = some["impact_count"].isel(yield_force=0).values.ravel()
    assert (counts > 0).all()
    for name in set(some.data_vars) - {"simulated"}:
        assert some[name].values.tobytes() == every[name].values.tobytes(), name
    assert float(some["energy_residual"].max()) < 1e-6
    # The law without a cap is pressed beyond F_E, and counted; the one with a cap never transmits more.
    peak, forces = some["peak_contact_force"].squeeze(), some["yield_force"].values
    capped = peak.isel(interface=1).values
    assert (capped[:2] <= forces[:2] * (1 + 1e-9)).all() and capped[2] > forces[0]
    free = peak.isel(interface=0).values
    reached = some["yield_exceedance"].squeeze().isel(interface=0).values
    np.testing.assert_array_equal(reached, (free >= forces).astype(int))
    assert reached[0] == 1


def test_compare_asks_for_one_model_to_calibrate_to():
    with pytest.raises(pr.PoundingError, match=r"the interfaces differ in their contact model \(jankowski, visc"):
        pr.compare(scene((0.005, 0.005)))


def test_a_run_and_an_accuracy_of_several_models():
    run = pr.simulate(scene((0.005, 0.005)))
    assert run.attrs["contact_model"] == OF_EACH_INTERFACE
    cases = scanned(scene((0.005, 0.005))).squeeze()
    np.testing.assert_array_equal(run["impact_count"].values, cases["impact_count"].values)
    np.testing.assert_array_equal(run["peak_contact_force"].values, cases["peak_contact_force"].values)
