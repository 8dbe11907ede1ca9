"""Floors that collide as elastic bars: against waves followed step by step, closed forms, whole runs, all commands."""

from __future__ import annotations

from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sentences import refusal
from test_impulsive import followed
from test_impulsive import scene as of_jumps
from typer.testing import CliRunner

import pounding_risk as pr
from pounding_risk import cli, figures
from pounding_risk.lab.stability.trial import SOFT, STIFF, WALL, shaking
from pounding_risk.models.contact.impulsive import DistributedMass, Stereomechanical
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.sdof import Building
from pounding_risk.questions.compare import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.pair.api import Interface, oscillators, solve
from pounding_risk.studies import compare_findings
from pounding_risk.studies.compare import models_left_out, on_equal_terms, reference_impacts
from pounding_risk.studies.impact import impact

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


def scene(left="15 m", right="24 m", **interface):
    """A scene in the shape of its file; floors without a length where none is told."""
    tables = of_jumps(**{"contact_model": "distributed_mass", "yield_force": "20 MN"} | interface)
    for building, length in zip(tables["building"], (left, right), strict=True):
        building |= {"floor_length": length} if length else {}
    return tables | {"grid": {"gap": ["5 mm", "10 mm", "1 m"]}}


def test_a_run_of_colliding_floors_yields_and_is_drawn():
    study = scene_of(scene())
    assert study.stiffness is None
    assert study.law() == DistributedMass(15.0, 24.0)
    one = pr.simulate(study)
    figures.simulation_figure(one)
    assert one["yield_count"].item() > 0.0
    assert float(one["contact_force"].max()) == one["peak_contact_force"].item()


def test_compare_says_that_e_is_its_own(capsys, says):
    """The reference impact is that of both floors as they are; without their lengths the model is left out aloud."""
    tables = scene(contact_model="linear", stiffness="5e8 N/m")
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
    without = scene_of(scene(left="", contact_model="linear", stiffness="5e8 N/m", restitution=0.65))
    assert "distributed_mass" not in on_equal_terms(without, (), None, (None, None)).grid.contact_models
    assert 'distributed_mass: left without floor_length; write floor_length = "20 m"' in models_left_out({"": without})
    says(refusal(pr.compare, without, laws=["distributed_mass"]))


def test_a_wall_is_struck_from_either_side():
    """One rigid building: e = 1 and v0 Z, whichever side it stands on."""
    for rigid in (0, 1):
        tables = scene(contact_model="linear", stiffness="5e8 N/m")
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
    ran = CliRunner().invoke(cli.app, [*words, "--floor-length", "10 m", "--other-floor-length", "20 m"])
    assert ran.exit_code == 0, ran.output
    assert "0.5000" in ran.stdout and "5.714 ms" in ran.stdout and "35 MN" in ran.stdout
    assert "distributed_mass: e is its own, that of waves in the floors" in ran.stdout
    for more, option in (([], "--floor-length"), (["--floor-length", "10 m"], "--other-floor-length")):
        ran = CliRunner().invoke(cli.app, [*words, *more])
        assert ran.exit_code == 2
        assert f'distributed_mass needs the length of the floors; write {option} "20 m"' in ran.stderr
    ran = CliRunner().invoke(cli.app, [*words[:3], "--floor-length", "10 m"])
    assert ran.exit_code == 0 and "1.0000" in ran.stdout, ran.output
