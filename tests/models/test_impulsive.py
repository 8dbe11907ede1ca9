"""Models whose velocities jump, and floors as elastic bars: formulas, bounces, waves in steps, all commands."""

from itertools import pairwise
from math import floor, inf, log, sqrt

import numpy as np
import pytest
import xarray as xr
from commands import done, refused
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle_jumps import Masses, Run
from sentences import refusal

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.lab.stability.trial import SOFT, STIFF, WALL, push, shaking
from pounding_risk.models.contact.impulsive import (
    CONTACT_MODELS,
    INSTANT_LAWS,
    DistributedMass,
    Merged,
    Stereomechanical,
)
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.models.structures.sdof import Building
from pounding_risk.questions.compare import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.counters import COMPLETE, make_log
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run, solve
from pounding_risk.studies import compare_findings
from pounding_risk.studies.compare import models_left_out, on_equal_terms, reference_impacts
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


ANY = Restitution(0.65)  # the model has no use for it
FLOORS = DistributedMass(15.0, 24.0)


class Bar:
    """An elastic bar in cells that a wave passes in one step each: v = f + g, compression Z (f − g), no other error.

    f goes to the right, g to the left. A fixed wall is a bar of infinite impedance that sends nothing back.
    """

    def __init__(self, mass, cells, step, speed):
        self.softness = 2.0 * cells * step / mass / 2.0  # 1/Z = T / (2 m)
        self.right, self.left = np.full(cells, 0.5 * speed), np.full(cells, 0.5 * speed)

    @property
    def speed(self):
        """Of the centre of mass."""
        return float(np.mean(self.right + self.left))


def waves(masses, cells, step, speed, until):
    """(force in every step, speeds of both centres at the end) of a left bar that meets a right one at rest.

    At the touching ends v and the force are equal, or there is no force: they part where it would be tension and may
    touch again where the ends have closed.
    """
    one = Bar(masses[0], cells[0], step, speed)
    other = Bar(masses[1], cells[1], step, 0.0) if masses[1] < inf else None
    forces, opening = [], 0.0
    for _ in range(until):
        out, towards = one.right[-1], other.left[0] if other else 0.0
        soft, stiff = one.softness, other.softness if other else 0.0
        force = 2.0 * (out - towards) / (soft + stiff)
        # Ends that are apart by no more than rounding touch.
        force = force if force > 1e-9 * speed / (soft + stiff) and opening <= 1e-9 * speed * step else 0.0
        one.left, back = np.append(one.left[1:], out - force * soft), one.left[0]
        one.right = np.append(back, one.right[:-1])
        ends = one.left[-1] + out
        if other:
            # The far ends are free: what arrives goes back as it is.
            arrived = other.right[-1]
            other.right = np.append(towards + force * stiff, other.right[:-1])
            other.left = np.append(other.left[1:], arrived)
            opening += (other.right[0] + towards - ends) * step
        else:
            opening -= ends * step
        forces.append(force)
    return np.array(forces), one.speed, other.speed if other else 0.0


BARS = {
    "equal impedances": ((4e5, 8e5), (20, 40)),
    "the short one softer": ((3e5, 9e5), (20, 31)),
    "the short one much softer": ((1e4, 9e5), (7, 50)),
    "the short one harder": ((9e5, 4e5), (20, 31)),
    "the short one much harder": ((9e5, 2e4), (7, 50)),
    "the short one harder, whole ratio": ((9e5, 4e5), (10, 30)),
    "seen from behind": ((4e5, 9e5), (31, 20)),
    "equal durations": ((9e5, 4e5), (25, 25)),
    "a wall": ((4e5, inf), (20, 0)),
}


@pytest.mark.parametrize("bars", BARS)
def test_waves_followed_step_by_step(bars):
    """Force in time, impulse, e, peak force and duration, to the rounding of some thousand steps.

    The bars have other wave speeds and thus lengths; the cells of each fit its speed.
    """
    (masses, cells), speed, step = BARS[bars], 0.7, 1e-4
    lengths = 3500.0 * cells[0] * step, 2100.0 * max(cells[1], 1) * step
    law = DistributedMass(*lengths, 3500.0, 2100.0)
    forces, one, other = waves(masses, cells, step, speed, 12 * max(cells))
    found = impact(law, speed, *masses)
    assert found.impulse == pytest.approx(forces.sum() * step, rel=1e-11)
    assert found.restitution == pytest.approx((other - one) / speed, abs=1e-11)
    assert found.peak_force == pytest.approx(forces.max(), rel=1e-12)
    pressed = np.flatnonzero(forces)
    assert np.all(np.diff(pressed) == 1)  # they part once and do not touch again
    assert found.duration == pytest.approx(len(pressed) * step, rel=1e-12)
    middles = (np.arange(len(pressed)) + 0.5) * step
    np.testing.assert_allclose(np.interp(middles, found.time, found.force), forces[pressed], rtol=1e-11)


LOTS = st.floats(1e-6, 1e6)


@given(masses=st.tuples(LOTS, LOTS), lengths=st.tuples(LOTS, LOTS), speeds=st.tuples(LOTS, LOTS))
@settings(max_examples=200, deadline=None)
def test_bounds_mirror_and_impulse(masses, lengths, speeds):
    """0 ≤ e ≤ 1; left and right to the bit; the steps of the force add up to the impulse (1 + e) m v0."""
    left, right = (1.0 / mass for mass in masses)
    law, behind = DistributedMass(*lengths, *speeds), DistributedMass(*lengths[::-1], *speeds[::-1])
    e, push, lasts = law.strike(1.0, left, right)
    assert 0.0 <= e <= 1.0
    assert push > 0.0
    assert lasts > 0.0
    assert behind.strike(1.0, right, left) == (e, push, lasts)
    transits = sorted(2.0 * length / speed for length, speed in zip(lengths, speeds, strict=True))
    if transits[1] < 200.0 * transits[0]:
        steps = list(law.course(left, right))
        assert steps[0] == (0.0, pytest.approx(steps[0][1]), push)
        assert all(one[1] == pytest.approx(other[0], rel=1e-12) for one, other in pairwise(steps))
        assert steps[-1][1] == pytest.approx(lasts, rel=1e-12)
        # Each end of a step rounds by 1e-16 of the time since the touch.
        total = sum((end - start) * force for start, end, force in steps)
        assert total * (left + right) == pytest.approx(1.0 + e, rel=1e-11)


def test_floors_too_unlike_for_a_history(says):
    says(refusal(impact, DistributedMass(1e-5, 1e3), 0.5, 4e5, 8e5))


@pytest.mark.parametrize("right", [STIFF, WALL])
def test_the_motion_is_that_of_its_jump(right):
    """The run of `stereomechanical` with this e, to the bit; besides it a force and a duration."""
    e, push, lasts = FLOORS.strike(1.0, *(each.inverse_mass for each in oscillators(SOFT, right)))
    ground = shaking(4.0)
    here, there = (Interface(0.003, law, Restitution(e)) for law in (FLOORS, Stereomechanical()))
    one, other = solve(SOFT, right, here, ground, 0.01), solve(SOFT, right, there, ground, 0.01)
    force = {"peak_contact_force", "contact_time", "yield_demand", "yield_exceedance", "yield_count"}
    for name in set(one) - force:
        assert one[name] == other[name] or np.isnan([one[name], other[name]]).all(), name
    contacts, _ = followed(SOFT, right, here, ground, 0.01)
    assert len(contacts) >= 5
    speeds = contacts[:, 2]
    np.testing.assert_array_equal(contacts[:, 4], push * speeds)
    assert one["peak_contact_force"] == push * speeds.max()
    # The union of the contacts' times; a sum of so many differences of times below 5 s.
    ends = np.minimum(contacts[:, 0] + lasts, 5.0)
    held = ends - np.maximum(contacts[:, 0], np.append(0.0, ends[:-1]))
    assert one["contact_time"] == pytest.approx(held.sum(), rel=1e-10)


def test_yielding_is_that_of_a_law_without_a_cap():
    """Exceedance, count and first time by hand from the contacts; `solve`, `scan` and `simulate` agree."""
    contacts, _ = followed(SOFT, STIFF, Interface(0.003, FLOORS, ANY), shaking(4.0), 0.01)
    forces = contacts[:, 4]
    level = float(np.sort(forces)[-3:-1].mean())
    found = solve(SOFT, STIFF, Interface(0.003, FLOORS, ANY, level), shaking(4.0), 0.01)
    assert (found["yield_exceedance"], found["yield_count"]) == (1.0, float(np.sum(forces >= level)))
    assert found["first_yield_time"] == contacts[np.argmax(forces >= level), 0]
    assert found["yield_demand"] == forces.max() / level
    never = solve(SOFT, STIFF, Interface(0.003, FLOORS, ANY, 1.001 * forces.max()), shaking(4.0), 0.01)
    assert (never["yield_exceedance"], never["yield_count"]) == (0.0, 0.0)
    assert np.isnan(never["first_yield_time"])


def test_a_resting_force_reaches_the_yield_force_where_it_does():
    """A mass held against a wall by a push that grows as 3 t m/s²: F = 3 m t, and reaches F_E at F_E / (3 m)."""
    ground = np.append(-3.0 * np.arange(101) * 0.01, np.full(20, -3.0))
    for level in (0.37e5, 1.9e5):
        interface = Interface(0.0, FLOORS, ANY, level)
        found = solve(Building("ball", 1e5, 1e4, 0.0), WALL, interface, ground, 0.01)
        assert found["impact_count"] == 1.0
        assert found["first_yield_time"] == pytest.approx(level / 3e5, rel=1e-9)
        assert found["peak_contact_force"] == pytest.approx(3e5, rel=1e-12)
        assert found["contact_time"] == pytest.approx(1.2, rel=1e-6)  # from the first push that is not rounding on
        assert found["yield_count"] == 1.0


def test_bounces_within_one_duration_count_once():
    """Ever smaller bounces, faster than the waves, e = 0.5: contact time is that from the first touch to the end.

    Floors of 3.5 km and more, so that 2 L / c is 2 s; the record ends while the mass rests, at 3 s.
    """
    ball, prop = Building("ball", 1e5, 1e4, 0.0), Building("prop", 2e5, 0.02, 0.05)
    interface = Interface(0.001, DistributedMass(3500.0, 7000.0), ANY)
    ground = np.full(301, -1.0)
    contacts, _ = followed(ball, prop, interface, ground, 0.01)
    found = solve(ball, prop, interface, ground, 0.01)
    assert found["impact_count"] == len(contacts) > 10
    assert np.all(np.diff(contacts[:, 1]) >= 0.0)
    assert contacts[0, 1] - contacts[0, 0] == pytest.approx(2.0, rel=1e-12)
    assert contacts[-1, 1] == 3.0
    assert found["contact_time"] == pytest.approx(3.0 - contacts[0, 0], rel=1e-12)


def of_floors(left="15 m", right="24 m", **interface):
    """A scene in the shape of its file; floors without a length where none is told."""
    tables = scene(**{"contact_model": "distributed_mass", "yield_force": "20 MN"} | interface)
    for building, length in zip(tables["building"], (left, right), strict=True):
        building |= {"floor_length": length} if length else {}
    return tables | {"grid": {"gap": ["5 mm", "10 mm", "1 m"]}}


def test_a_run_of_colliding_floors_yields_and_is_drawn():
    study = scene_of(of_floors())
    assert study.stiffness is None
    assert study.law() == DistributedMass(15.0, 24.0)
    one = pr.simulate(study)
    figures.simulation_figure(one)
    assert one["yield_count"].item() > 0.0
    assert float(one["contact_force"].max()) == one["peak_contact_force"].item()


def test_compare_says_that_e_is_its_own(capsys, says):
    """The reference impact is that of both floors as they are; without their lengths the model is left out aloud."""
    tables = of_floors(contact_model="linear", stiffness="5e8 N/m")
    dataset = pr.compare(scene_of(tables), laws=["distributed_mass"])
    one = dataset.sel(contact_model="distributed_mass").squeeze("interface")
    # T = 2 L / c and Z = m c / L: impedances 1 : 1, so that e = 15 / 24.
    assert float(one["reference_restitution"]) == pytest.approx(15.0 / 24.0, rel=1e-12)
    force = 0.5 * 0.5 * 500e3 * 3500.0 / 15.0
    assert float(one["reference_peak_force"]) == pytest.approx(force, rel=1e-12)
    assert int(one["dissipates"]) == 1
    ratios = one["ratio_median"]
    assert np.isfinite(float(ratios.sel(output="peak contact force")))
    assert np.isnan(float(ratios.sel(output="peak floor acceleration, left")))
    assert compare_findings.comparable_laws(dataset) == []  # neither e nor the force is on equal terms
    figures.reference_figure(dataset)
    edge = [text.get_text() for text in figures.agreement_figure(dataset).axes[1].texts]
    assert edge == [f"{float(ratios.sel(output='peak contact force')):.2g}"]
    print_sheet(sheet(dataset.assign_attrs(left_out="merged: not asked for")))
    told = capsys.readouterr().out
    assert "e and force are its own: nothing can be made equal" in told
    assert "excluded merged: not asked for" in " ".join(told.split())
    without = scene_of(of_floors(left="", contact_model="linear", stiffness="5e8 N/m", restitution=0.65))
    assert "distributed_mass" not in on_equal_terms(without, (), None, (None, None)).grid.contact_models
    assert 'distributed_mass: left without floor_length; write floor_length = "20 m"' in models_left_out({"": without})
    says(refusal(pr.compare, without, laws=["distributed_mass"]))


def test_a_wall_is_struck_from_either_side():
    """One rigid building: e = 1 and v0 Z, whichever side it stands on."""
    for rigid in (0, 1):
        tables = of_floors(contact_model="linear", stiffness="5e8 N/m")
        tables["building"][rigid] = {"name": "wall", "rigid": True}
        tables["grid"]["contact_model"] = ["linear", "distributed_mass"]
        study = scene_of(tables)
        assert scene_of(study.resolved()) == study
        _, found = reference_impacts(study, {"linear": 5e8})
        mass, length = ((800e3, 24.0), (500e3, 15.0))[rigid]
        assert found.restitution == 1.0
        assert found.peak_force == pytest.approx(0.5 * mass * 3500.0 / length, rel=1e-14)


def test_the_command_impact():
    words = ["impact", "--law", "distributed_mass", "--mass", "400 t", "--other-mass", "800 t"]
    told = done(*words, "--floor-length", "10 m", "--other-floor-length", "20 m").stdout
    assert "0.5000" in told and "5.714 ms" in told and "35 MN" in told
    assert "distributed_mass: e is its own, that of waves in the floors" in told
    for more, option in (([], "--floor-length"), (["--floor-length", "10 m"], "--other-floor-length")):
        needed = f'distributed_mass needs the length of the floors; write {option} "20 m"'
        assert needed in refused(*words, *more)
    assert "1.0000" in done(*words[:3], "--floor-length", "10 m").stdout
