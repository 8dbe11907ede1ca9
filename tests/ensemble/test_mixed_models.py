"""A row whose interfaces have contact models of their own: limits that equal rows of one model, and what is counted."""

from __future__ import annotations

import numpy as np
import pytest
from figure_words import words_of

import pounding_risk as pr
from pounding_risk.figures.compare import agreement_figure, reference_figure
from pounding_risk.questions.compare import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.scene.values import OF_EACH_INTERFACE
from pounding_risk.studies.compare_findings import of_interface

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


def test_both_touch_and_the_law_with_a_cap_alone_keeps_it():
    some = scanned(scene((0.005, 0.005)).replace(yield_force=["300 kN", "700 kN", "inf"]))
    counts = some["impact_count"].isel(yield_force=0).values.ravel()
    assert (counts > 0).all()
    assert float(some["energy_residual"].max()) < 1e-6
    # The law without a cap is pressed beyond F_E, and counted; the one with a cap never transmits more.
    peak, forces = some["peak_contact_force"].squeeze(), some["yield_force"].values
    capped = peak.isel(interface=1).values
    assert (capped[:2] <= forces[:2] * (1 + 1e-9)).all() and capped[2] > forces[0]
    free = peak.isel(interface=0).values
    reached = some["yield_exceedance"].squeeze().isel(interface=0).values
    np.testing.assert_array_equal(reached, (free >= forces).astype(int))
    assert reached[0] == 1


@pytest.mark.complete
def test_a_comparison_is_calibrated_to_the_model_of_each_interface():
    """Where the other interface never closes, it is the comparison of a row of the one model."""
    for place, own in enumerate(MODELS):
        gaps = (0.005, FAR) if place == 0 else (FAR, 0.005)
        mixed = pr.compare(scene(gaps), laws=["hertz_damp"])
        alone = pr.compare(scene(gaps, (own, own)), laws=["hertz_damp"])
        assert mixed.attrs["baseline"] == mixed.attrs["reference_law"] == OF_EACH_INTERFACE
        here, there = (one.isel(interface=place) for one in (mixed, alone))
        assert int(here["impact_count"].min()) > 0
        for name in ("stiffness", "reference_peak_force", "peak_contact_force", "flips", "judged"):
            assert here[name].values.tobytes() == there[name].values.tobytes(), name
        assert mixed["ratio_median"].values.tobytes() == alone["ratio_median"].values.tobytes()
        moved = f"against {OF_EACH_INTERFACE}, peak contact force, {'A | B' if place == 0 else 'B | C'} is"
        assert mixed.attrs["finding"].startswith(f"The model matters here: {moved}")


def test_a_comparison_of_stiffnesses_in_two_units(capsys):
    """k beside β: every interface calibrates to its own, in its own unit."""
    row = scene((0.005, 0.005)).replace('interface.2.contact_model="kelvin_voigt"', 'interface.2.stiffness="1e8 N/m"')
    compared = pr.compare(row, laws=["hertz_damp", "kelvin_voigt"])
    own = compared.sel(contact_model=OF_EACH_INTERFACE)
    assert own["stiffness"].values.tolist() == [2.75e9, 1e8]
    assert [str(of_interface(compared, place)["stiffness_unit"].values[-1]) for place in (0, 1)] == ["N/m^1.5", "N/m"]
    forces = compared["reference_peak_force"].values
    np.testing.assert_allclose(forces, np.broadcast_to(forces[:, -1:], forces.shape), rtol=1e-6)
    assert compared["stiffness"].sel(contact_model="kelvin_voigt").values[1] == 1e8
    print_sheet(sheet(compared, "B | C"))
    assert f"Ratio to {OF_EACH_INTERFACE}" in capsys.readouterr().out
    for figure in (agreement_figure(compared), reference_figure(compared, interface="A | B")):
        assert "no force against" not in words_of(figure)
