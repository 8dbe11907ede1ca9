"""Storeys by the Hazus rule: period, strengths and limits against eigenvalues, sums and published formulas."""

import numpy as np
import pytest
from sentences import refusal

import pounding_risk as pr
from pounding_risk.streets.hazus import FAMILIES, LEVELS, NO_CODE, chain, family_of, type_of, types
from pounding_risk.streets.rows import read_block, write_block

MASS, G = 2e5, 9.80665
STREET = """name,storeys,floor area [m^2],hazus type,code level,gap [mm],height [m],period
old,5,200,C1M,low,20,16,
new,3,150,RM2,high,50,,
wall,2,120,,,,,0.3 s
"""


def read(folder, text, **rules):
    (folder / "street.csv").write_text(text, encoding="utf-8")
    return read_block(folder / "street.csv", pr.streets.Rules(**rules))


def modes(count, stiffness):
    """Angular frequencies and shapes of a uniform shear chain, by numpy from its matrices."""
    stiffnesses = stiffness * (2.0 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    stiffnesses[-1, -1] = stiffness
    values, shapes = np.linalg.eigh(stiffnesses / MASS)
    return np.sqrt(values), shapes


TYPICAL = [("C1", 1, "C1L", 0.2), ("C1", 5, "C1M", 0.75), ("S2", 13, "S2H", 1.77), ("URM", 3, "URMM", 0.5)]


@pytest.mark.parametrize(("family", "storeys", "name", "period"), [*TYPICAL, ("W1", 2, "W1", 0.7)])
def test_a_chain_has_the_period_of_its_type_and_yields_at_its_capacity(family, storeys, name, period):
    """The typical building of table 5.5 has its typical period; V_1 = A_y g times the mass of the first mode."""
    kind = type_of(family, storeys)
    made = chain(kind, "low", storeys, MASS)
    frequencies, shapes = modes(storeys, made.stiffness)
    assert kind.name == name and made.period == pytest.approx(period, rel=1e-12)
    assert 2.0 * np.pi / frequencies[0] == pytest.approx(period, rel=1e-9)
    first = shapes[:, 0]
    moved = MASS * first.sum() ** 2 / (first @ first)
    assert made.strengths[0] == pytest.approx(kind.levels["low"].yield_acceleration * G * moved, rel=1e-9)
    forces = np.arange(1, storeys + 1)  # that grow with the height: a storey carries those above it
    shears = np.cumsum(forces[::-1])[::-1] / forces.sum()
    np.testing.assert_allclose(made.strengths, made.strengths[0] * shears, rtol=1e-12)


def test_a_five_storey_frame_as_worked_out_by_hand():
    """C1M of moderate code, 200 t: A_y 0.104 g, T 5 × 0.15 s; a = π / 11, k = π² m / (T sin(a / 2))², α_1 0.87953."""
    made = chain(type_of("C1", 5), "moderate", 5, MASS)
    assert made.stiffness == pytest.approx(173.263e6, rel=1e-5)
    assert made.strengths[0] == pytest.approx(0.104 * 9.80665 * 0.87953 * 1e6, rel=1e-5)
    assert made.drifts == (0.0033, 0.0058, 0.0156, 0.04)


@pytest.mark.parametrize("storeys", [1, 2, 3, 5, 8, 13, 30])
def test_the_polynomials_of_mdof_lu_come_within_their_fit(storeys):
    """K_0 = 4 π² λ m / T_0² and S_y = A_y α_1 n m g r of NHERI-SimCenter's HazusSAM_Generator.cpp."""
    kind, n = type_of("C2", storeys), float(storeys)
    made = chain(kind, "pre", storeys, MASS)
    polynomial = 0.4053 * n**2 + 0.405 * n + 0.1869
    assert made.stiffness == pytest.approx(4.0 * np.pi**2 * polynomial * MASS / (n * kind.period) ** 2, rel=3e-3)
    share = 0.09117 / n**3 - 0.3037 / n**2 + 0.402 / n + 0.8106
    base = kind.levels["pre"].yield_acceleration * share * MASS * G * n
    assert made.strengths[0] == pytest.approx(base, rel=1e-3)


def test_the_table_is_whole_and_weaker_by_older_codes():
    assert len(types()) == 35
    assert {family for family in FAMILIES if type_of(family, 2) is None} == {"MH"}
    for kind in types().values():
        strengths = [kind.levels[level].yield_acceleration for level in LEVELS]
        assert strengths == sorted(strengths, reverse=True) and len(strengths) == 4
        assert all(list(level.drifts) == sorted(level.drifts) for level in kind.levels.values())
        if family_of(kind.name) in NO_CODE:
            assert kind.levels["high"] == kind.levels["low"]
    assert (family_of("c1m"), family_of("URML"), family_of("PC1"), family_of("X9")) == ("C1", "URM", "PC1", "")


def test_block_writes_storeys_strengths_and_states_and_lists_each(tmp_path, says):
    street = read(tmp_path, STREET, chain="hazus")
    files = write_block(street, tmp_path / "out", records=["RSN6-180"])
    scene = pr.read_scene(files[0])
    assert [building.period for building in scene.buildings] == pytest.approx([0.75, 3 * 0.175, 0.3], rel=1e-5)
    assert [len(building.strengths) for building in scene.buildings] == [5, 3, 2]
    assert scene.buildings[1].height == pytest.approx(3 * 10 * 0.3048, rel=1e-5)  # ten feet a storey
    assert [building.damping for building in scene.buildings] == [0.07, 0.1, 0.1]
    assert [(state.name, state.threshold) for state in scene.damage][:5] == [
        *(("old, slight", 0.0033), ("old, moderate", 0.0053), ("old, extensive", 0.0133), ("old, complete", 0.0333)),
        ("new, slight", 0.004),
    ]
    assert "inelastic_storeys" in dict(scene.effects)
    says([f"{value.building}, {value.column}: {value.value}; {value.rule}" for value in street.filled])


@pytest.mark.parametrize("change", [("C1M", "C9"), ("low", "lowest"), ("RM2", "MH")], ids="-".join)
def test_an_unknown_type_or_level_is_refused_with_its_line(tmp_path, change, says):
    says(refusal(read, tmp_path, STREET.replace(*change), chain="hazus"))


def test_a_typology_follows_from_a_type_where_storeys_are_those_of_typologies(tmp_path):
    street = read(tmp_path, STREET)
    assert [house.typology for house in street.rows[0].buildings] == ["concrete_frame", "masonry", "masonry"]
    told = {(value.building, value.column): value.rule for value in street.filled}
    assert told["old", "typology"] == "its hazus type C1M" and "stated" in told["wall", "typology"]
    assert all(house.chain is None for house in street.rows[0].buildings)


def test_rules_know_their_words(says):
    says(refusal(pr.streets.Rules, chain="hazu"), refusal(pr.streets.Rules, code_level="middle"))
    says(refusal(pr.streets.Rules, code_level="moderate"))  # the level that holds without it, of no storeys here
