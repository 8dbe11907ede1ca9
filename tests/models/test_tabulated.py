"""The tabulated law: against closed forms, SciPy's curve and integrator, and what no cycle may give back."""

import copy
import json
import pathlib
import pickle
from math import inf, pi, sqrt

import numpy as np
import pytest
from commands import done, refused
from damaged_tables import survey
from hypothesis import given, settings
from hypothesis import strategies as st
from paths import Path, follow_pair
from scenes import scene_text, single
from scipy.interpolate import PchipInterpolator
from sentences import refusal
from sweeps import examples, many, sweep

import pounding_risk as pr
from pounding_risk.lab.stability.trial import SOFT, STIFF, largest_difference, shaking
from pounding_risk.models.contact import table as tables
from pounding_risk.models.contact.laws import Hertz, Linear, Tabulated
from pounding_risk.models.contact.table import TableError, table_of
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.results.opened import Results
from pounding_risk.scene.reader import parse_scene, read_scene
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.pair.api import Interface, solve
from pounding_risk.studies.impact import impact

# Made, not measured: a bumper that stiffens, with a way back; a filler that yields, with a stiffness on its way back.
BUMPER = ([0.0, 0.01, 0.02, 0.03], [0.0, 1e5, 3e5, 6e5], [0.0, 0.0, 0.5e5, 6e5])
FILLER = ([0.0, 0.002, 0.005, 0.02], [0.0, 2.5e5, 4e5, 5e5])
K_BACK = 3e8
LAWS = {
    "bumper": Tabulated.of(*BUMPER),
    "filler": Tabulated.of(*FILLER, unloading_stiffness=K_BACK),
    "elastic": Tabulated.of(*FILLER),
}
FILE = """# made
penetration [mm],force [kN],unloading [kN]
0,0,0
10,100,0
20, 300,50
30,600,600
"""


# ------------------------------------------------------------------------------------------------ closed forms


def test_a_straight_table_is_the_linear_law():
    """To the bit with the points 0 and 1, in an impact and a run; to 1e-9 with others, and beyond the last."""
    one, other, short = (
        impact(law, 0.5, 570.0) for law in (Tabulated(1e8), Linear(1e8), Tabulated.of([0.0, 3e-4], [0.0, 3e4]))
    )
    assert np.array_equal(one.force, other.force) and np.array_equal(one.penetration, other.penetration)
    for name in ("peak_force", "peak_penetration", "duration", "restitution"):
        assert getattr(short, name) == pytest.approx(getattr(other, name), rel=1e-9)
    assert short.beyond_table() and not one.beyond_table()
    runs = [
        solve(SOFT, STIFF, Interface(0.003, kind, constant(1.0)), shaking(4.0, duration=2.0), 0.01)
        for kind in (Tabulated(1e8), Linear(1e8))
    ]
    assert all(one[energy] == 0.0 for one in runs for energy in ("energy_plastic", "energy_viscous"))
    assert runs[0]["impact_count"] >= 3.0 and largest_difference(*runs) == 0.0


@pytest.mark.parametrize("back", [1e8, 2.5e8, 4e9])
def test_straight_in_and_back_with_another_stiffness(back: float):
    """δ = v sqrt(m/k), F = k δ, e² = k / K_u, a quarter of a period on either way; the steps end on the turn."""
    k, mass, speed = 1e8, 570.0, 0.5
    found = impact(Tabulated.of([0.0, 0.1], [0.0, k * 0.1], unloading_stiffness=back), speed, mass)
    assert found.peak_penetration == pytest.approx(speed * sqrt(mass / k), rel=1e-9)
    assert found.peak_force == pytest.approx(speed * sqrt(mass * k), rel=1e-9)
    assert found.restitution == pytest.approx(sqrt(k / back), rel=1e-9)
    assert found.duration == pytest.approx(0.5 * pi * (sqrt(mass / k) + sqrt(mass / back)), rel=1e-9)
    assert found.energy_lost == pytest.approx(0.5 * mass * speed**2 * (1.0 - k / back), abs=1e-9 * mass * speed**2)


@pytest.mark.parametrize("speed", [0.3, 1.0, 4.0])
def test_straight_in_and_back_along_a_column(speed: float):
    """Back from F δ / 2 comes the share of the reach; beyond the table's end the reach is that of the table."""
    k, mass, end, left = 1e8, 1e4, 0.02, 0.005
    law = Tabulated.of([0.0, left, end], [0.0, k * left, k * end], [0.0, 0.0, k * end])
    found, deepest = impact(law, speed, mass), speed * sqrt(mass / k)
    reach = (1.0 - left / end) * min(deepest, end)
    assert found.peak_penetration == pytest.approx(deepest, rel=1e-9)
    assert found.restitution == pytest.approx(sqrt(reach / deepest), rel=1e-9)
    assert found.penetration[-1] == pytest.approx(deepest - reach, rel=1e-9)  # of the gap as it was built: the set
    assert bool(found.beyond_table()) == (deepest > end)


def test_hertz_as_a_table_converges():
    """The elastic part of Jankowski's law, β δ^1.5, at equal spacing h: errors fall with h^2.5.

    The first cell holds a curvature without bound, and a cubic misses the energy there by h^2.5; elsewhere h³ or less.
    """
    beta, speed, mass = 2.75e9, 1.0, 1e4
    true, errors = impact(Hertz(beta), speed, mass), []
    for count in (16, 32, 64, 128, 256):
        x = np.linspace(0.0, 1.2 * true.peak_penetration, count + 1)
        found = impact(Tabulated.of(x, beta * x**1.5), speed, mass)
        assert found.restitution == pytest.approx(1.0, abs=1e-6)
        names = ("peak_force", "peak_penetration", "duration")
        errors.append([abs(getattr(found, name) / getattr(true, name) - 1.0) for name in names])
    orders = -np.polyfit(np.log([16, 32, 64, 128, 256]), np.log(errors), 1)[0]
    assert np.all(orders > 2.3) and np.all(orders < 2.8), orders
    assert np.max(errors[2]) < 3e-6  # 64 points


@pytest.mark.parametrize("name", LAWS)
def test_force_and_energy_are_those_of_the_curve(name: str):
    """SciPy's own monotone cubic and its antiderivative, to rounding; a straight line beyond the end."""
    law = LAWS[name]
    points = law.table.points
    curve = PchipInterpolator(points.penetration, points.force)
    energy, memory = curve.antiderivative(), law.begin(1.0, 0.5, 1e3)
    end, last = points.penetration[-1], points.force[-1]
    for delta in np.linspace(0.0, end, 97):
        assert law.force(memory, delta, 0.0, True) == pytest.approx(float(curve(delta)), rel=1e-12, abs=1e-9)
        assert law.stored(delta, inf) == pytest.approx(float(energy(delta)), rel=1e-12, abs=1e-12)
    slope, further = float(curve.derivative()(end)), 0.4 * end
    assert law.force(memory, end + further, 0.0, True) == pytest.approx(last + slope * further, rel=1e-12)
    beyond = float(energy(end)) + further * (last + 0.5 * slope * further)
    assert law.stored(end + further, inf) == pytest.approx(beyond, rel=1e-12)


def test_errors_follow_the_tolerance():
    """Steps pass the points, where the curvature jumps: within 30 rtol in an impact across all points."""
    for law in LAWS.values():
        true = impact(law, 1.5, 1e4, rtol=1e-13)
        for rtol in (1e-4, 1e-6, 1e-8):
            found = impact(law, 1.5, 1e4, rtol=rtol)
            for name in ("peak_force", "peak_penetration", "restitution", "impulse"):
                assert getattr(found, name) == pytest.approx(getattr(true, name), rel=30.0 * rtol), (law, rtol, name)


# ------------------------------------------------------------------------------------------------ memory


class Remembered(Path):
    """The law's path in the words of its definition: SciPy's curves and δ from the gap as it was built."""

    def __init__(self, penetration, force, unloading=None, back=None):
        self.loading, self.back, self.end = PchipInterpolator(penetration, force), back, penetration[-1]
        self.slope = float(self.loading.derivative()(self.end))
        if unloading is not None:
            begins = max(np.flatnonzero(np.array(unloading) == 0.0))
            self.share = 1.0 - penetration[begins] / self.end
            x = (np.array(penetration[begins:]) - penetration[begins]) / (self.end - penetration[begins])
            with np.errstate(over="ignore"):
                self.shape = PchipInterpolator(x, np.array(unloading[begins:]) / force[-1])
        self.deepest, self.left = 0.0, 0.0

    def virgin(self, delta):
        inside = min(delta, self.end)
        return float(self.loading(inside)) + self.slope * (delta - inside)

    def force(self, delta):
        if delta >= self.deepest:
            return self.virgin(delta)
        if delta <= self.left:
            return 0.0
        if self.back is not None:
            return self.back * (delta - self.left)
        return self.virgin(self.deepest) * float(self.shape((delta - self.left) / (self.deepest - self.left)))

    def turned(self, delta, inwards=True):
        if inwards and delta > self.deepest:
            self.deepest = delta
            reach = self.share * min(delta, self.end) if self.back is None else self.virgin(delta) / self.back
            self.left = delta - reach


@pytest.mark.parametrize("name", sweep(["bumper", "filler"], "bumper"))
def test_a_run_against_scipy(name: str):
    """Whole run, crushing and all: to 1e-5, what the fine samples and SciPy's steps over the points leave."""
    pair = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 0.31, 0.05)
    ground = shaking(2.0, duration=3.0)
    path = Remembered(*BUMPER) if name == "bumper" else Remembered(*FILLER, back=K_BACK)
    found = solve(*pair, Interface(0.004, LAWS[name], constant(1.0)), ground, 0.01, rtol=1e-10)
    largest, force, touches = follow_pair(*pair, 0.004, path, ground, 0.01)
    assert touches == found["impact_count"] >= 3.0
    assert found["peak_relative_displacement"] == pytest.approx(largest, rel=1e-5)
    assert found["peak_contact_force"] == pytest.approx(force, rel=1e-4)
    assert found["permanent_set"] == pytest.approx(path.left, rel=1e-5) and path.left > 0.001


@pytest.mark.parametrize("name", ["bumper", "filler"])
def test_ledger_and_set_of_a_run(name: str):
    """No damper: all loss is the loop's. The set is that of the deepest closing, and the energy of the virgin curve."""
    law, gap = LAWS[name], 0.004
    found = solve(SOFT, STIFF, Interface(gap, law, constant(1.0)), shaking(3.0, duration=3.0), 0.01)
    assert found["status"] == COMPLETE and found["impact_count"] > 3.0
    assert found["energy_residual"] <= 1e-6 and found["energy_viscous"] == 0.0 <= found["lowest_contact_force"]
    path = Remembered(*BUMPER) if name == "bumper" else Remembered(*FILLER, back=K_BACK)
    path.turned(found["peak_closing"] - gap)
    assert found["permanent_set"] == pytest.approx(path.left, rel=1e-6)
    # What all cycles have lost is what the curve took to the deepest point, less what springs back from there.
    depth = np.linspace(0.0, path.deepest, 20001)
    back = np.linspace(path.left, path.deepest * (1.0 - 1e-12), 20001)
    lost = np.trapezoid([path.virgin(x) for x in depth], depth) - np.trapezoid([path.force(x) for x in back], back)
    assert found["energy_plastic"] == pytest.approx(lost, rel=1e-4)
    again = solve(STIFF, SOFT, Interface(gap, law, constant(1.0)), -shaking(3.0, duration=3.0), 0.01)
    for output in ("peak_closing", "peak_contact_force", "impulse", "permanent_set", "energy_plastic", "contact_time"):
        assert again[output] == found[output], output


# ------------------------------------------------------------------------------------------------ no cycle gains


def work(law: Tabulated, turns: list[float]) -> list[float]:
    """Work of the force in contacts that go to each of these depths in turn, from the gap as built, and part."""
    losses, damage, left = [], 0.0, 0.0
    for deepest in turns:
        memory = law.resume(law.begin(1.0, 0.5, 1e3), damage)
        reach = deepest - left
        if reach <= 0.0:
            continue
        corner = min(memory[3], reach)
        taken = 0.0
        for low, high in ((0.0, corner), (corner, reach)):
            x = np.linspace(low, high, 801)
            taken += np.trapezoid([law.force(memory, max(one, 0.0), 0.0, True) for one in x], x)
        changed, indentation, lost = law.crushed(memory, reach)
        assert lost == 0.0
        if indentation >= 0.0:
            memory, left, reach = changed, left + indentation, reach - indentation
        x = np.linspace(0.0, reach, 801)
        back = [law.force(memory, one, 0.0, False) for one in x]
        assert min(back) >= 0.0
        assert law.held(memory, reach, inf) == pytest.approx(np.trapezoid(back, x), rel=1e-3, abs=1e-9)
        losses.append(taken - np.trapezoid(back, x))
        damage = law.damage(memory)
    return losses


@st.composite
def made_tables(draw):
    """Columns of a table: points of any spacing, forces that rise or fall, and a way back of either kind."""
    count = draw(st.integers(1, 8))
    steps = draw(st.lists(st.floats(0.5, 4.0), min_size=count, max_size=count))
    rises = draw(st.lists(st.floats(-0.3, 3.0), min_size=count, max_size=count))
    x = np.concatenate([[0.0], np.cumsum(steps)]) * 1e-3
    y = np.concatenate([[0.0], np.maximum(np.cumsum(rises), 0.05)]) * 1e5
    if draw(st.booleans()):
        return x, y, None, draw(st.floats(1.0, 20.0)) * float(np.max(y[1:] / x[1:]))
    shares = sorted(draw(st.lists(st.floats(0.0, 1.0), min_size=count, max_size=count)))
    back = np.concatenate([[0.0], np.minimum.accumulate((y[1:] * shares)[::-1])[::-1]])
    back[-1] = y[-1]
    return x, y, back, None


@examples(30, made_tables(), st.lists(st.floats(0.05, 1.5), min_size=1, max_size=5))
def test_no_cycle_gives_back_more_than_it_takes(columns, turns):
    """Of every table that is taken, to within the quadrature."""
    try:
        law = Tabulated.of(*columns)
    except TableError as error:
        assert "give back more" in str(error) or "must not fall" in str(error)
        return
    end, scale = law.table.end, float(np.max(columns[1]) * law.table.end)
    for lost in work(law, [turn * end for turn in turns]):
        assert lost >= -2e-4 * scale


test_no_cycle_of_many_gives_back_more = many(test_no_cycle_gives_back_more_than_it_takes, 150)


@settings(max_examples=60, deadline=None)
@given(made_tables(), st.floats(0.02, 1.3), st.floats(2.0, 5.0))
def test_an_impact_on_any_table_is_that_of_its_energies(columns, share, digits):
    """Peak penetration where the curve has taken the energy, e² what springs back of it; both from SciPy's cubics."""
    try:
        law = Tabulated.of(*columns)
    except TableError:
        return
    path = Remembered(*columns[:3], back=columns[3])
    deepest = share * path.end
    inside = min(deepest, path.end)
    level = max(path.slope, 0.0)
    brought = float(path.loading.antiderivative()(inside))
    brought += (deepest - inside) * (float(path.loading(inside)) + 0.5 * level * (deepest - inside))
    mass = 10.0**digits
    found = impact(law, sqrt(2.0 * brought / mass), mass, rtol=1e-10)
    top = float(path.loading(inside)) + level * (deepest - inside)
    if columns[3] is not None:
        back = top * top / (2.0 * columns[3])
    else:
        back = top * path.share * inside * float(path.shape.integrate(0.0, 1.0))
    assert found.peak_penetration == pytest.approx(deepest, rel=1e-6)
    assert found.restitution == pytest.approx(sqrt(back / brought), rel=1e-6)
    assert found.energy_lost == pytest.approx(brought - back, abs=1e-6 * brought)


@pytest.mark.parametrize(
    ("columns", "turns"),
    [
        (([0.0, 0.01, 0.02], [0.0, 1e5, 4e5], None, 2.2e7), [0.02]),
        (
            ([0.0, 0.001, 0.002, 0.01, 0.02], [0.0, 1e3, 2e3, 2e5, 4e5], [0.0, 0.9e3, 1.9e3, 1.9e5, 4e5], None),
            np.linspace(0.001, 0.02, 20).tolist(),
        ),
    ],
)
def test_a_refused_way_back_would_gain(monkeypatch, columns, turns):
    """The check refuses what does give energy in some cycle, here found without it."""
    assert "give back more" in refusal(table_of, *columns, kind=TableError)
    monkeypatch.setattr(tables, "_energy_faults", lambda points: [])
    monkeypatch.setattr(tables, "_TABLES", {})
    assert min(work(Tabulated.of(*columns), turns)) < -1.0  # J


# ------------------------------------------------------------------------------------------------ tables and files


def test_a_table_is_one_object_for_its_content():
    one = table_of(*BUMPER)
    assert one is table_of(["0 mm", "10 mm", "20 mm", "30 mm"], ["0 N", "100 kN", "300 kN", "600 kN"], BUMPER[2])
    assert pickle.loads(pickle.dumps(one)) is one and copy.deepcopy(LAWS["bumper"]) == LAWS["bumper"]
    assert one != table_of(*BUMPER[:2]) and one.stiffness == 2e7 and one.end == 0.03


POINTS = {
    "one point": ([0.0], [0.0]),
    "a depth twice": ([0.0, 0.1, 0.1], [0.0, 1.0, 2.0]),
    "a beginning past zero": ([0.1, 0.2], [1.0, 2.0]),
    "a force below zero": ([0.0, 0.1], [0.0, -1.0]),
    "a force that is no number": ([0.0, 0.1], [0.0, float("nan")]),
    "no force": ([0.0, 0.1], [0.0, 0.0]),
    "too few forces": ([0.0, 0.1], [0.0]),
    "unloading above loading": ([0.0, 0.1, 0.2], [0.0, 5.0, 6.0], [0.0, 5.5, 6.0]),
    "ways that do not meet": ([0.0, 0.1, 0.2], [0.0, 5.0, 6.0], [0.0, 1.0, 5.0]),
    "two ways back": ([0.0, 0.1], [0.0, 5.0], [0.0, 5.0], 1e3),
    "a soft way back": ([0.0, 0.1], [0.0, 5.0], None, 49.0),
    "no list": ("abc", [0.0, 1.0]),
}
FILES = {
    "a column misspelt": "penetration [mm],forze [kN]\n0,0\n1,1\n",
    "a letter": "penetration [mm],force [kN]\n0,0\n\n# no\n1,x\n",
    "no unit": "penetration [mm],force\n0,0 kN\n1,5\n",
    "out of order": "penetration [mm],force [kN]\n0,0\n2,5\n1,7\n",
    "a time": "penetration [s],force [kN]\n0,0\n2,1\n",
    "no depths": "force [kN],unloading [kN]\n0,0\n",
}


@pytest.mark.parametrize("fault", POINTS)
def test_points_that_make_no_table(fault: str, says):
    says(refusal(Tabulated.of, *POINTS[fault], kind=TableError))


@pytest.mark.parametrize("fault", FILES)
def test_files_that_are_no_table(tmp_path: pathlib.Path, fault: str, says):
    (tmp_path / "bumper.csv").write_text(FILES[fault])
    says(refusal(Tabulated.from_file, tmp_path / "bumper.csv", kind=TableError))


@pytest.mark.parametrize("count", sweep([300, 2000], 300))
def test_a_file_that_is_damaged_is_told(tmp_path: pathlib.Path, count: int):
    path = tmp_path / "bumper.csv"
    path.write_text(FILE)

    def check(law):
        assert np.all(np.isfinite(law.table.numbers))

    assert min(survey(path, lambda: Tabulated.from_file(path), check, count, longest=20_000).values()) > count / 100


# ------------------------------------------------------------------------------------------------ scenes


PAIR = single("A", "44 t", "0.21 s"), single("B", "83 t", "0.07 s")


def bumper_scene(tmp_path: pathlib.Path, pair=PAIR, **interface) -> pathlib.Path:
    (tmp_path / "bumper.csv").write_text(FILE)
    keys = {"stiffness": None, "restitution": None, "gap": "5 mm", "table": "bumper.csv"} | interface
    text = scene_text(*pair, law="tabulated", records={"window": ["1 s", "5 s"], "pga": "0.5 g"}, **keys)
    (tmp_path / "scene.toml").write_text(text)
    return tmp_path / "scene.toml"


def test_a_scene_reads_its_table_and_stands_alone(tmp_path: pathlib.Path):
    """The resolved scene has the points; the identity of a study follows the file's content, not its name."""
    path = bumper_scene(tmp_path)
    scene = read_scene(path)
    assert scene.law() == LAWS["bumper"] and scene.stiffness == 2e7
    assert parse_scene(scene.to_toml()) == scene and "bumper.csv" not in scene.to_toml()
    assert scene.to_toml(as_written=True).count("bumper.csv") == 1
    built = pr.Interface(gap="5 mm", law=LAWS["bumper"])
    assert scene.replace(interfaces=[built]) == scene
    (tmp_path / "other.csv").write_text(FILE.replace("600", "700"))
    other = scene.replace('interface.table="other.csv"')
    assert other.law() == Tabulated.of(BUMPER[0], [0, 1e5, 3e5, 7e5], [0, 0, 5e4, 7e5]) and other != scene
    harder = scene.replace('interface.stiffness="4e7 N/m"').law()
    memory = harder.begin(1.0, 0.5, 1e3)
    assert harder.force(memory, 0.02, 0.0, True) == pytest.approx(6e5, rel=1e-12)


def test_results_stand_alone_and_say_where_the_table_ends(tmp_path: pathlib.Path):
    path = bumper_scene(tmp_path)
    results = pr.scan(path, tmp_path / "long.nc")
    assert not any("last point" in note for note in Results(results).notes)
    (tmp_path / "bumper.csv").unlink()
    from pounding_risk.questions.rerun import rerun

    assert rerun(tmp_path / "long.nc").same
    short = bumper_scene(tmp_path, table={"penetration": ["0 mm", "2 mm"], "force": ["0 kN", "20 kN"]})
    notes = Results(pr.scan(short)).notes
    assert any(note.startswith("A | B, in 1 case: the penetration of") for note in notes), notes
    assert "the table's last point, 2 mm" in " ".join(json.loads(pr.simulate(short).attrs["notes"]))


def test_other_models_beside_a_table(tmp_path: pathlib.Path, says):
    """A table keeps its forces beside a law of another unit; without one the model is left out, or refused."""
    path = bumper_scene(tmp_path, contact_model="jankowski", stiffness="1e9 N/m^1.5", restitution=0.65)
    scene = read_scene(path, ['grid.contact_model=["jankowski", "tabulated"]'])
    assert scene.law("tabulated") == LAWS["bumper"] and not scene.needs_equal_terms("tabulated")
    bare = scene_text()
    says(refusal(pr.compare, parse_scene(bare), laws=["jankowski", "tabulated"]))
    says(refusal(parse_scene, bare.replace('"jankowski"', '"tabulated"').replace("2.75e9 N/m^1.5", "1e8 N/m")))
    left = bumper_scene(tmp_path, stiffness="1e9 N/m^1.5")
    sentence = refusal(read_scene, left)
    assert "remove it: the forces of the table have their own stiffness" in sentence and "write a" not in sentence


KEYS = {
    "a number": "3",
    "no such file": '"none.csv"',
    "a letter in a list": '{penetration = ["0 mm", "x"], force = ["0 N", "1 N"]}',
    "two ways back": '{file = "bumper.csv", unloading_stiffness = "1 N/m"}',
    "a file and points": '{file = "bumper.csv", force = []}',
    "no forces": '{penetration = ["0 mm"]}',
}


@pytest.mark.parametrize("fault", KEYS)
def test_faults_of_the_key(tmp_path: pathlib.Path, fault: str, says):
    says(refusal(read_scene, bumper_scene(tmp_path), [f"interface.table={KEYS[fault]}"]))


def test_advice_keeps_a_table(tmp_path: pathlib.Path):
    """Another stiffness would scale what was measured; the loop is not said to return all energy."""
    advice = pr.advise(bumper_scene(tmp_path))
    (line,) = [line for line in advice.lines if line.interface == "A | B"]
    assert line.line == "" and line.why.startswith("Keep the forces of the table")
    assert {one.factor for one in advice.influences} == {"stiffness"}
    (restitution,) = [note for note in advice.left_out if note.startswith("restitution")]
    assert restitution == "restitution: tabulated takes none"


def test_methods_that_know_no_path_are_left_out(tmp_path: pathlib.Path):
    dataset = pr.accuracy(bumper_scene(tmp_path), cases=1, budget=1.0)
    assert "they know no tabulated" in dataset.attrs["left_out"]


def test_impact_of_the_command_line(tmp_path: pathlib.Path, says):
    """The loop of the file, and where its points end; without a file the option is asked for."""
    (tmp_path / "bumper.csv").write_text(FILE)
    words = ["impact", "--law", "tabulated", "--mass", "5 t", "--speed", "2.5 m/s"]
    printed = done(*words, "--table", tmp_path / "bumper.csv").output
    found = impact(LAWS["bumper"], 2.5, 5e3)
    assert f"{found.restitution:.4f}" in printed and "table of 4 points to 30 mm and 600 kN" in printed
    assert "passes the table's last point, 30 mm" in printed and "passes the table's last point" in repr(found)
    says(refused(*words))


def test_what_has_no_place_for_a_table_says_so(tmp_path: pathlib.Path, says):
    """Not the straight line that stands in for a table: a street's scenes, and impacts of verification cases."""
    (tmp_path / "street.csv").write_text("name,height [m],storeys,typology,gap [mm]\nA,9,3,concrete_frame,\n")
    words = ["block", str(tmp_path / "street.csv"), "--contact-model", "tabulated", "--out", str(tmp_path / "out")]
    shipped = pathlib.Path(pr.__file__).parent / "lab" / "verification" / "cases" / "anagnostopoulos_1988.toml"
    case = shipped.read_text("utf-8").replace('"kelvin_voigt"', '"tabulated"')
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    says(refused(*words), refusal(pr.verify, tmp_path))
