"""Models whose velocities jump: Goldsmith's formulas, trains of bounces, joined motion against SciPy, all commands."""

from __future__ import annotations

from itertools import pairwise
from math import floor, inf, log, sqrt

import numpy as np
import pytest
import xarray as xr
from oracle_jumps import Masses, Run
from sentences import refusal

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.lab.stability.trial import SOFT, STIFF, WALL, push, shaking
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, INSTANT_LAWS, Merged, Stereomechanical
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.models.structures.sdof import Building
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.counters import COMPLETE, make_log
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run, solve
from pounding_risk.studies.impact import impact

MODELS = (Merged(), Stereomechanical())
HALF = Restitution(0.5)


def followed(left, right, interface, ground, dt, rtol=1e-6):
    """(contacts, steps) of one run."""
    pair = oscillators(left, right)
    kept = make_log(2000, 20_000, np.zeros(0))
    run(pair, free_response(pair, ground, dt), interface, rtol, kept)
    return kept.contacts[: kept.used[0]], kept.steps[: kept.used[1]]


def test_the_models_are_told_from_laws_of_force():
    assert list(INSTANT_LAWS) == ["stereomechanical", "merged", "distributed_mass"]
    assert set(INSTANT_LAWS) < set(CONTACT_MODELS)


@pytest.mark.parametrize("e", [0.05, 0.65, 1.0])
@pytest.mark.parametrize("other", [3e5, 2e11, inf])
def test_goldsmith(e, other):
    """v1' = v1 − (1 + e) m v0 / m1; impulse (1 + e) m v0; energy (1 − e²) m v0² / 2. Rounding only: 1e-14."""
    mass, speed = 5e5, 0.7
    reduced = 1.0 / (1.0 / mass + 1.0 / other)
    found = impact(Stereomechanical(), speed, mass, other, restitution=e)
    assert found.restitution == pytest.approx(e, rel=1e-14)
    assert found.impulse == pytest.approx((1.0 + e) * reduced * speed, rel=1e-14)
    assert found.energy_lost == pytest.approx(0.5 * (1.0 - e * e) * reduced * speed**2, rel=1e-14)
    assert (found.duration, found.peak_penetration) == (0.0, 0.0)
    assert np.isnan(found.peak_force)
    if other < inf:
        assert abs(found.momentum_change) < 1e-11  # M × the rounding of its small speed, over the impulse


def test_concrete_falls_with_the_speed():
    slow, fast = (impact(Stereomechanical(), speed, 5e5, restitution=CONCRETE) for speed in (0.1, 2.0))
    assert slow.restitution == pytest.approx(CONCRETE.at(0.1), rel=1e-14)
    assert fast.restitution == pytest.approx(CONCRETE.at(2.0), rel=1e-14)


@pytest.mark.parametrize("e", [0.5, 0.9])
def test_a_train_of_bounces_ends_at_rest(e):
    """A mass under a constant push A, its spring negligible, falls on a wall: flights of 2 e^k v0 / A, then rest.

    The spring's share is ω² gap / A = 4e-9, and the first fall starts from rest under a full push: 1e-7.
    """
    ball, drop, pull, end = Building("ball", 1e5, 1e4, 0.0), 0.01, 1.0, 4.0
    ground = np.full(401, -pull)
    interface = Interface(drop, Stereomechanical(), Restitution(e))
    contacts, steps = followed(ball, WALL, interface, ground, 0.01)
    first, speed = sqrt(2.0 * drop / pull), sqrt(2.0 * drop * pull)
    slowest = 1e-6 * pull * end  # rtol × the fastest free closing speed
    bounces = floor(log(slowest / speed) / log(e))
    assert len(contacts) == bounces + 1
    flights = 2.0 * speed / pull * e ** np.arange(1, bounces + 1)
    touches = first + np.concatenate([[0.0], np.cumsum(flights)])
    np.testing.assert_allclose(contacts[:, 0], touches, rtol=1e-7)
    np.testing.assert_allclose(contacts[:, 2], speed * e ** np.arange(bounces + 1), rtol=1e-3, atol=1e-8)
    # The whole train lasts 2 e v0 / (A (1 − e)); after it the mass rests on the wall until the record ends.
    whole = first + 2.0 * speed * e / (pull * (1.0 - e))
    assert contacts[-1, 0] == pytest.approx(whole, abs=3.0 * slowest / pull / (1.0 - e))
    assert contacts[-1, 1] == pytest.approx(end, rel=1e-12)
    static = ball.mass * pull - ball.stiffness * drop
    assert steps[-1, 5] == pytest.approx(static, rel=1e-12)
    assert steps[-1, 1] == drop
    found = solve(ball, WALL, interface, ground, 0.01)
    assert found["peak_contact_force"] == pytest.approx(static, rel=1e-12)
    assert found["impulse"] == pytest.approx(ball.mass * pull * end, rel=1e-7)
    assert found["energy_viscous"] == pytest.approx(0.5 * ball.mass * speed**2, rel=1e-7)


@pytest.mark.parametrize(("model", "e"), [(Merged(), 0.0), (Stereomechanical(), 0.5)])
def test_whole_runs_against_scipy(model, e):
    """Touches, partings and impulse, to 1e-6; the reference, which has rows of any length, is good to 1e-9."""
    gap, ground = 0.004, shaking(4.0)[:301]
    facts = (np.array([getattr(side, name) for side in (SOFT, STIFF)]) for name in ("mass", "period", "damping"))
    known = Run(Masses(*facts, np.array([gap]), np.array([e])), ground, 0.01, np.zeros(1)).solve()
    interface = Interface(gap, model, Restitution(max(e, 0.1)))
    contacts, _ = followed(SOFT, STIFF, interface, ground, 0.01, 1e-9)
    assert len(contacts) >= 5
    np.testing.assert_allclose(contacts[:, 0], known.touches[0], rtol=1e-6)
    lasting = contacts[contacts[:, 1] > contacts[:, 0]]
    assert len(lasting) >= (1 if e == 0.0 else 0)
    np.testing.assert_allclose(lasting[:, 1], known.rests[0], rtol=1e-6)
    assert contacts[:, 9].sum() == pytest.approx(known.impulse[0], rel=1e-6)


def test_it_parts_where_the_force_is_zero():
    """F = m (A_left − A_right) from the state at the parting, over its peak; momentum is kept at every join."""
    ground, dt = shaking(4.0), 0.01
    contacts, steps = followed(SOFT, STIFF, Interface(0.0, Merged(), HALF), ground, dt)
    lasting = contacts[(contacts[:, 1] > contacts[:, 0]) & (contacts[:, 1] < 4.99)]
    assert len(lasting) >= 3
    left, right = oscillators(SOFT, STIFF)
    for contact in lasting:
        last = steps[int(contact[11]) - 1]
        assert (last[0], last[5]) == (pytest.approx(contact[1], rel=1e-14), 0.0)
        pulls = [o.two_zeta_omega * last[3 + side] + o.omega2 * last[1 + side] for side, o in enumerate((left, right))]
        force = (pulls[1] - pulls[0]) / (left.inverse_mass + right.inverse_mass)
        assert abs(force) < 1e-9 * contact[4]
    pairs = pairwise(steps)
    jumps = [(a, b) for a, b in pairs if a[0] == b[0] and b[7] > 0.0]
    assert len(jumps) >= 3
    for before, after in jumps:
        momenta = [SOFT.mass * row[3] + STIFF.mass * row[4] for row in (before, after)]
        scale = SOFT.mass * abs(before[3]) + STIFF.mass * abs(before[4])
        assert momenta[1] == pytest.approx(momenta[0], abs=1e-14 * scale)
        assert after[3] == after[4]


def test_no_rebound_is_merged():
    """e → 0: what rebounds with 1e-12 of the approach speed comes back within rounding."""
    merged, jump = (solve(SOFT, STIFF, Interface(0.005, m, Restitution(1e-12)), shaking(4.0), 0.01) for m in MODELS)
    assert merged["impact_count"] >= 3
    for name in ("peak_relative_displacement", "impulse", "energy_viscous", "peak_contact_force", "contact_time"):
        assert jump[name] == pytest.approx(merged[name], rel=1e-8), name


@pytest.mark.parametrize("model", MODELS)
def test_twins_never_touch_and_a_push_is_held(model):
    """Equal buildings; then a push that rests: F = (k2 m1 − k1 m2) a / (k1 + k2), as statics have it."""
    twins = solve(SOFT, SOFT, Interface(0.0, model, HALF), shaking(4.0), 0.01)
    assert (twins["impact_count"], twins["peak_relative_displacement"]) == (0.0, 0.0)
    left, right = SOFT._replace(damping=0.3), STIFF._replace(damping=0.3)
    _, steps = followed(left, right, Interface(0.0, model, HALF), push(-3.0, 1.0, 20.0), 0.01)
    stiffness = left.stiffness + right.stiffness
    static = 3.0 * (right.stiffness * left.mass - left.stiffness * right.mass) / stiffness
    assert steps[-1, 5] == pytest.approx(static, rel=1e-9)  # what vibrated has fallen by more than 1e-9
    assert steps[-1, 1] == pytest.approx(3.0 * (left.mass + right.mass) / stiffness, rel=1e-9)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("gap", [0.0, 1e-6, 0.003])
@pytest.mark.parametrize("right", [STIFF, WALL, Building("tower", 2e6, 1.9, 0.02)])
def test_no_run_chatters_for_ever(model, gap, right):
    """Closed and narrow gaps, rigid and slender neighbours: complete, and energy closes to rounding."""
    found = solve(SOFT, right, Interface(gap, model, CONCRETE), shaking(5.0), 0.01)
    assert found["status"] == COMPLETE
    assert 0 < found["impact_count"] < 2000
    assert found["energy_residual"] < 1e-12
    assert found["peak_penetration"] == 0.0
    assert found["peak_closing"] <= gap + 1e-15
    assert (found["yield_exceedance"], found["yield_count"]) == (-1.0, -1.0)
    assert np.isnan(found["yield_demand"])


def scene(**interface):
    """A scene of both models, in the shape of a scene file."""
    return {
        "building": [
            {"name": "left", "mass": "500 t", "period": "0.5 s"},
            {"name": "right", "mass": "800 t", "period": "0.31 s"},
        ],
        "interface": [{"gap": "5 mm", "contact_model": "merged", **interface}],
        "records": {"names": ["RSN6-180"], "window": ["0 s", "6 s"], "pga": "0.5 g"},
        "grid": {"gap": ["5 mm", "10 mm", "1 m"], "contact_model": ["merged", "stereomechanical"]},
    }


def test_scan_simulate_and_figures(tmp_path):
    """All commands, without a stiffness in the scene; netCDF keeps what is not defined."""
    study = scene_of(scene(restitution="concrete", yield_force="300 kN"))
    assert study.stiffness is None
    found = pr.scan(study, tmp_path / "instant.nc", check_fraction=1.0)
    with xr.open_dataset(tmp_path / "instant.nc") as kept:
        assert kept["yield_exceedance"].isel(gap=0).values.ravel().tolist() == [-1, -1]
        assert kept["yield_exceedance"].isel(gap=2).values.ravel().tolist() == [0, 0]
        assert np.all(kept["status"] == COMPLETE)
    # What was made again at rtol / 100 bounces a little longer on its way to rest, and moves by no more than rtol.
    assert found["change_peak_relative_displacement"].max() <= 1e-6
    for model in study.grid.contact_models:
        run = pr.simulate(study, law=model)
        taken = run["energy_damping"].values
        # Dampers only take: what falls is the rounding of the ledger, jumps included.
        assert np.diff(taken).min() > -1e-9 * run["energy_ground"].max()
        assert run["energy_contact"][-1] == pytest.approx(float(run["energy_viscous"][0]))
        figures.simulation_figure(run)
    figures.impact_figure([impact(Stereomechanical(), 0.5, 5e5, restitution=0.65), impact(Merged(), 0.5, 5e5)])


def test_a_law_of_force_beside_them_needs_a_stiffness(says):
    tables = scene(restitution=0.65)
    tables["grid"]["contact_model"] = ["merged", "jankowski"]
    says(refusal(scene_of, tables))
    tables["interface"][0]["stiffness"] = "2.75e9 N/m^1.5"
    study = scene_of(tables)
    assert (study.stiff_name, study.law("jankowski").stiffness) == ("jankowski", 2.75e9)
    assert scene_of(study.resolved()) == study
    says(refusal(scene_of(scene(restitution=0.65)).law, "jankowski"))
    says(refusal(scene_of, scene()))
