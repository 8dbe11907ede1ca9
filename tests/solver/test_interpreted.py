"""Kernels compute the same numbers compiled and interpreted: expressions over modules of tests, evaluated in both."""

import json
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from processes import compiled, interpreted


class Case(NamedTuple):
    """What is computed with the names of a module of tests, and to what it agrees.

    Nothing is contracted or reordered: roots, powers and sums of a matrix of a library round otherwise.
    """

    module: str
    expression: str  # of values that JSON has
    rtol: float
    least: tuple[str, float] = ("", 0.0)  # an output of each run that has this value at least
    atol: float = 1e-15
    but: str = ""  # an output that is a rounding itself


WAVED = "Interface(0.004, law, HALF), GROUND[:200], STEP, supports=WavePassage(LAG).supports(2)"
CASES = {
    "closings": Case(
        "test_closings",
        "[part.tolist() for part in largest_closings(noise(6, 150), 0.02, side([0.15, 0.4]), side([0.3, 0.9], 0.1))]",
        1e-13,
    ),
    "listed closings": Case(
        "test_closings", "[part.tolist() for part in PairList(*drawn(3)).closings(noise(6, 150), 0.02)]", 1e-13
    ),
    "a wave past a pair": Case(
        "test_wave_passage",
        f"[solve(FRAME, right, {WAVED}) for law, right in ((LAW, SHED), (Merged(), SHED), (Merged(), ROCK))]",
        1e-11,
        ("impact_count", 1.0),
        but="energy_residual",
    ),
    "a wave past a row": Case(
        "test_row_wave", "run_of(*ROWS['storeys, single, storeys'], GROUND[:120], rtol=1e-6).floors.tolist()", 1e-11
    ),
    "storeys with laws": Case(
        "test_hysteresis",
        "[free_row(lay_out([chain_of(building(law, 2), [('inelastic_storeys', [])])], [], 0.01), 3.0 * SHAKING[:150])"
        ".floors.tolist() for law in (PINCHED, Hysteresis('isotropic'), Hysteresis('kinematic'), "
        "bouc_wen(SMOOTH['degrading']))]",
        1e-10,
    ),
    "links with laws": Case(
        "test_links",
        "[run(model(*OF_LAWS[name]), 0.006, GROUND[60:160], DT, 1e-6).floors.tolist()"
        " for name in ('friction', 'hook that breaks', 'damper', 'damper on a brace')]",
        1e-9,
    ),
    "mass matrices": Case(
        "test_matrix_rows",
        "by_solver(STRIKE._replace(chains=(chain_of(HEAVY.structure()), STRIKE.chains[1])), 1e-6)"
        ".floors[:, [0, 1, 3]].tolist()",
        1e-9,
    ),
    "two components": Case(
        "test_rotating_floors",
        "[pr.scan(scene({'plan': ACROSS}, {'plan': OTHER_ACROSS}, gap='3 mm', "
        "records=BOTH | {'window': ['2 s', '2.6 s']}), check_fraction=0.0)[name].values.tolist()"
        " for name in ('peak_closing', 'storey_acceleration', 'impulse')]",
        1e-9,
    ),
    "jumps of a row": Case(
        "test_row_jumps",
        "[{key: value.tolist() for key, value in Made(*ROWS[name][:2], shaking(4.0)[:200], "
        "e=tuple(map(Restitution, ROWS[name][2]))).outputs().items()} for name in ('closed', 'wall')]",
        1e-10,
        ("impact_count", 3.0),
    ),
    "floors as bars": Case(
        "test_impulsive",
        "[solve(SOFT, STIFF, Interface(0.003, law, ANY, 2e7), shaking(4.0)[:300], 0.01)"
        " for law in (FLOORS, DistributedMass(3.0, 80.0))]",
        1e-12,
        ("impact_count", 3.0),
    ),
    "jumps of a pair": Case(
        "test_impulsive",
        "[solve(SOFT, STIFF, Interface(0.003, law, HALF), shaking(4.0)[:300], 0.01) for law in MODELS]",
        1e-12,
        ("impact_count", 1.0),
    ),
    "tables": Case(
        "test_tabulated",
        "[solve(SOFT, STIFF, Interface(0.004, law, constant(1.0)), shaking(3.0, duration=1.5), 0.01)"
        " for law in LAWS.values()]",
        1e-12,
        ("impact_count", 1.0),
    ),
    "an exact relation": Case(
        "test_exact_damping",
        "[getattr(pr.impact(Jankowski(2.75e9), SPEED, MASS, restitution=0.65, relation='exact'), name)"
        " for name in ('restitution', 'peak_force', 'duration')]",
        1e-12,
    ),
    # Fused products may round otherwise.
    "all effects": Case(
        "test_effects",
        "[solve(LEFT, RIGHT, Interface(0.002, with_all(ViscousElastoplastic(BETA)), constant(0.65), 6e5), "
        "shaking(5.0, duration=1.5), 0.01, supports=WavePassage(0.018).supports(2))]",
        1e-9,
        ("permanent_set", 1e-6),
        1e-9,
    ),
}


@pytest.fixture(scope="module")
def known() -> dict[str, Any]:
    """All of them, by one process that compiles nothing."""
    lines = ["import json", "from importlib import import_module", "found = {}"]
    for name, case in CASES.items():
        lines.append(f"found[{name!r}] = eval({case.expression!r}, {{**vars(import_module({case.module!r}))}})")
    return interpreted("\n".join([*lines, "print(json.dumps(found))"]))


def flat(values: Any, but: str) -> list[float]:
    """All numbers, in the order in which they stand."""
    if isinstance(values, dict):
        return [one for key, value in values.items() if key != but for one in flat(value, but)]
    return [one for value in values for one in flat(value, but)] if isinstance(values, list) else [float(values)]


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("name", CASES)
def test_interpreted_is_compiled(name: str, known: dict[str, Any], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "models")
    case = CASES[name]
    found = json.loads(json.dumps(eval(case.expression, {**vars(import_module(case.module))})))
    output, least = case.least
    assert not output or all(np.sum(run[output]) >= least for run in found)
    np.testing.assert_allclose(flat(found, case.but), flat(known[name], case.but), case.rtol, case.atol)
