"""Links between neighbours against SciPy in physical coordinates, closed forms, and rows that are the same without.

Oracle: matrices that are put together here, with DOP853; the motion without contact of linked buildings is that of one
linear system.
"""

from __future__ import annotations

import re
from math import inf, sqrt
from pathlib import Path

import numpy as np
import pytest
from oracle_rows import stiffness_matrix
from oracle_springs import Linear, extremes
from row_cases import EL_CENTRO, single, storeys
from scenes import scene_text, storeyed
from scenes import single as mass
from scipy.linalg import block_diag
from sentences import refusal
from sweeps import sweep

import pounding_risk as pr
from pounding_risk.ensemble.limits import fastest_rate
from pounding_risk.ensemble.row_grid import model_of, without_jumps
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.links import Link, bodies_of
from pounding_risk.models.structures.mdof import Chain
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver import counters
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import HIGHEST, LOWEST, Contacts
from pounding_risk.solver.row.model import RowModel

LINEAR = LAWS["linear"](4e8)


def model(chains: tuple[Chain, ...], places: list[tuple[int, float, float]], links: list[Link]) -> RowModel:
    return RowModel(chains, [Point(*place, FLOOR, 0.0) for place in places], links=links)


def run(row: RowModel, gap: float, acceleration: np.ndarray, dt: float, rtol: float = 1e-10):
    count = len(row.points)
    gaps = row.gaps(np.full(len(row.chains) - 1, gap))
    contacts = Contacts(gaps, np.full(count, inf), [LINEAR] * count, [constant(1.0)] * count)
    return rows.run_row(row.row(dt), contacts, acceleration, rtol=rtol)


def by_scipy(chains, touching, links, gap, ground, dt):
    """Peaks |u| by mass, highest closings, stretches and shortenings of the links, and the peak force."""
    firsts = np.concatenate([[0], np.cumsum([chain.mass.size for chain in chains])])
    stiffness = block_diag(*[stiffness_matrix(chain.spring) for chain in chains])
    damping = block_diag(*[chain.damping for chain in chains])
    size = len(stiffness)

    def across(interface, left, right):
        ends = np.zeros(size)
        if chains[interface].mass.size:
            ends[firsts[interface] + int(left) - 1] += 1.0
        if chains[interface + 1].mass.size:
            ends[firsts[interface + 1] + int(right) - 1] -= 1.0
        return ends

    for link in links:
        ends = across(*link[:3])
        stiffness += link.stiffness * np.outer(ends, ends)
        damping += link.damping * np.outer(ends, ends)
    shares = np.array([across(*place) for place in touching])
    system = Linear(np.concatenate([chain.mass for chain in chains]), stiffness, damping, shares, 4e8, gap)
    watched = [*np.eye(size), *shares, *(-across(*link[:3]) for link in links)]
    found, stretched = extremes(system, ground, dt, 200, watched), size + len(shares)
    peak = np.maximum(found.high, -found.low)[:size]
    return peak, found.high[size:stretched], [found.high[stretched:], -found.low[stretched:]], found.force.max()


HALL, TOWER, SHED = storeys(3, 60e3, 9e7), storeys(2, 90e3, 8e7), single(120e3, 0.25)
WALL = SHED._replace(mass=np.zeros(0), spring=np.zeros(0), shear=np.zeros(0), damping=np.zeros((0, 0)))
ROWS = {
    "two buildings": ((HALL, TOWER), [(0, 2.0, 2.0)], [Link(0, 2.0, 2.0, 2e7, 4e5)]),
    "a damper alone": ((HALL, TOWER), [(0, 2.0, 2.0)], [Link(0, 2.0, 2.0, 0.0, 8e5)]),
    "two links": ((HALL, TOWER), [(0, 2.0, 2.0)], [Link(0, 1.0, 1.0, 5e6, 0.0), Link(0, 2.0, 1.0, 0.0, 3e5)]),
    "the first two of three": ((HALL, TOWER, SHED), [(0, 2.0, 2.0), (1, 1.0, 1.0)], [Link(0, 1.0, 1.0, 3e7, 1e5)]),
    "the last two of three": ((SHED, HALL, TOWER), [(0, 1.0, 1.0), (1, 2.0, 2.0)], [Link(1, 2.0, 2.0, 3e7, 1e5)]),
    "a mass and a wall": ((SHED, WALL), [(0, 1.0, 1.0)], [Link(0, 1.0, 1.0, 3e7, 3e5)]),
    "all three": (
        (HALL, SHED, TOWER), [(0, 1.0, 1.0), (1, 1.0, 1.0)], [Link(0, 1.0, 1.0, 8e6, 3e5), Link(1, 1.0, 2.0, 8e6, 0.0)]
    ),
}  # fmt: skip


@pytest.mark.parametrize("gap", sweep([inf, 0.004], 0.004))
@pytest.mark.parametrize("name", sweep(ROWS, "two links", "a mass and a wall", "all three"))
def test_linked_rows_are_those_of_scipy(name: str, gap: float):
    """SciPy's peaks are the largest of 200 places an interval of 0.4 rad at most: 0.5 (0.4 / 398)² = 5e-7 too low.

    A penetration is a tenth of the closing here, and its relative error ten times that.
    """
    chains, touching, links = ROWS[name]
    ground, dt = EL_CENTRO._replace(start=1.5, stop=3.5, pga=0.5).samples()
    peak, high, low, force = by_scipy(chains, touching, links, gap, ground, dt)
    row = model(chains, touching, links)
    found = run(row, gap, ground, dt)
    assert found.status == counters.COMPLETE
    np.testing.assert_allclose(found.floors[:, 0], peak, rtol=2e-6)
    contacts, watched = found.points[~row.is_link], found.points[row.is_link]
    np.testing.assert_allclose(contacts[:, HIGHEST], high, rtol=2e-6)
    np.testing.assert_allclose([-watched[:, LOWEST], watched[:, HIGHEST]], low, rtol=2e-6)
    assert contacts[:, counters.PEAK_FORCE].max() == pytest.approx(force, rel=1e-5)
    assert (force > 0.0) == (gap < inf)
    free = rows.free_row(row.row(dt), ground)
    if gap == inf:
        np.testing.assert_allclose(found.floors[:, [0, 1, 3]], free.floors[:, [0, 1, 3]], rtol=1e-12)


def test_a_link_without_stiffness_and_damping_is_none():
    """One linear system of both gives the motion of each alone, but for rounding, which contacts let grow."""
    chains, touching, _ = ROWS["two buildings"]
    ground, dt = EL_CENTRO._replace(pga=0.5).samples()
    linked = run(model(chains, touching, [Link(0, 2.0, 2.0, 0.0, 0.0)]), 0.004, ground, dt)
    plain = run(model(chains, touching, []), 0.004, ground, dt)
    np.testing.assert_allclose(linked.floors, plain.floors, rtol=1e-9)
    np.testing.assert_allclose(linked.points[:1], plain.points, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("interfaces", [(0,), (1,), (0, 1)])
def test_contacts_that_follow_others_are_found_between_linked_buildings(interfaces: tuple[int, ...]):
    """Free motion passes by blocks, with what earlier contacts have left: the bounds count both ends of every point."""
    chains = single(500e3, 1.0), single(800e3, 0.5), single(400e3, 0.8)
    places = [(0, 1.0, 1.0), (1, 1.0, 1.0)]
    ground, dt = EL_CENTRO._replace(name="RSN753-000", start=0.0, stop=20.0, pga=0.3).samples()
    plain = run(model(chains, places, []), 0.06, ground, dt)
    linked = model(chains, places, [Link(interface, 1.0, 1.0, 0.0, 0.0) for interface in interfaces])
    found = run(linked, 0.06, ground, dt)
    assert plain.points[1, counters.COUNT] > 5
    # Rounding, which contacts let grow: 1e-9 of a displacement is 1e-8 of a penetration.
    np.testing.assert_allclose(found.points[~linked.is_link][:, HIGHEST], plain.points[:, HIGHEST], rtol=1e-8)
    np.testing.assert_allclose(found.floors, plain.floors, rtol=1e-7)


def test_buildings_that_links_join_are_bodies():
    chains = (HALL, TOWER, SHED, HALL)
    assert [(body.first, body.last) for body in bodies_of(chains, [Link(1, 1.0, 1.0, 1e6, 0.0)])] == [
        (0, 0), (1, 2), (3, 3)
    ]  # fmt: skip
    assert [(body.first, body.last) for body in bodies_of(chains, [Link(2, 1.0, 1.0, 1e6, 0.0)])][-1] == (4, 3)


SCENE = scene_text(
    mass("A", "100 t", "0.5 s", height="9 m"), mass("B", "120 t", "0.3 s", height="9 m"), gap="15 mm",
    records={"names": ["RSN6-180"], "window": ["0 s", "8 s"], "pga": "0.4 g"},
)  # fmt: skip


def test_the_scene_of_the_page_has_its_links():
    """That of docs/rows.md: one at the roof of the lower building and one part-way up a column."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "rows.md").read_text("utf-8")
    (text,) = (block for block in re.findall(r"^```toml\n(.*?)^```", page, re.M | re.S) if "link_at" in block)
    study = parse_scene(text)
    assert sorted(study.links) == [Link(0, 2.0, 1.9, 0.0, 2e6), Link(0, 3.0, 3.0, 0.0, 2e6)]


def test_histories_of_a_link_are_its_force_and_agree_with_the_scan():
    study = parse_scene(SCENE, overrides=['interface.link_stiffness="4 MN/m"', 'interface.link_damping="0.2 MN s/m"'])
    history, results = pr.simulate(study), pr.scan(study)
    stretch = history["link_stretch"].values[:, 0]
    assert history["peak_link_stretch"].item() == results["peak_link_stretch"].item()  # one and the same run
    assert stretch.max() == pytest.approx(history["peak_link_stretch"].item(), rel=1e-3)  # of instants 5 ms apart
    velocity = history["velocity"].values[:, :, 0]
    known = 4e6 * stretch + 2e5 * (velocity[:, 1] - velocity[:, 0])
    np.testing.assert_allclose(history["link_force"].values[:, 0], known, rtol=1e-9, atol=1e-3)
    assert parse_scene(study.to_toml()) == study


def test_an_elevation_of_a_run_says_that_links_are_not_drawn():
    towers = (storeyed("A", "60 t", "90 MN/m", storeys=2), storeyed("B", "90 t", "80 MN/m", storeys=2))
    keys = {"gap": "4 mm", "records": {"names": ["RSN6-180"], "window": ["1.5 s", "2.5 s"]}}
    for link, is_said in (({"link_stiffness": "4 MN/m"}, True), ({}, False)):
        figure = pr.figures.simulation_figure(pr.simulate(parse_scene(scene_text(*towers, **keys, **link))))
        assert any("links are not drawn" in axis.get_title() for axis in figure.axes) == is_said


def test_links_that_cannot_be_are_refused(says):
    def told(*overrides: str) -> str:
        return refusal(parse_scene, SCENE, overrides=overrides)

    says(told('interface.link_at=[{left="storey 1",right="storey 1"}]'))
    says(told('interface.link_damping="-1 kN s/m"', 'interface.link_stiffness="3 kN"'))
    says(told('interface.link_damping="1 kN s/m"', 'interface.link_at=[{left="storey 2",right="storey 1"}]'))
    says(told('interface.link_damping="1 kN s/m"', "building.B.ground_factor=-1.0"))
    says(told('interface.link_damping="1 kN s/m"', 'effects.wave_passage={velocity="300 m/s", distance="9 m"}'))
    says(told('interface.link_damping="1 kN s/m"', 'interface.contact_model="stereomechanical"'))
    of_file = told('interface.link_damping="1 kN s/m"', 'building.A.displacement_history="a.csv"')
    assert "link_damping: A has a displacement_history, which no link can change; remove one of the two" in of_file
    both = parse_scene(SCENE, overrides=['interface.link_damping="1 kN s/m"'])
    says(without_jumps(both, "stereomechanical"))


def test_the_fastest_rate_of_a_linked_scene_is_above_its_eigenvalues():
    study = parse_scene(SCENE, overrides=['interface.link_stiffness="400 MN/m"'])
    chain = model_of(study).bodies[0].chain
    known = sqrt(np.linalg.eigvals(chain.stiffness() / chain.mass[:, None]).real.max())
    assert known <= fastest_rate(study) <= 1.5 * known
