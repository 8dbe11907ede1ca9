"""The explicit Runge-Kutta method of the contact phase, as a table that checks itself."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


def _dense(sparse: dict[int, float], length: int) -> np.ndarray:
    row = np.zeros(length)
    for column, value in sparse.items():
        row[column] = value
    return row


@dataclass(frozen=True)
class Tableau:
    """An embedded explicit Runge-Kutta method; refuses a wrong digit when it is made.

    ``rows`` are the stage coefficients a_ij by column, ``weights`` the b_j, ``errors`` the coefficients of the
    error estimators (each sums to zero). Checked: row sums equal the nodes, Σ b = 1, and the quadrature
    conditions Σ b c^(q−1) = 1/q up to the order.
    """

    name: str
    order: int
    reference: str
    nodes: tuple[float, ...]
    rows: tuple[dict[int, float], ...]
    weights: dict[int, float]
    errors: tuple[dict[int, float], ...]
    a: np.ndarray = field(init=False, repr=False)
    b: np.ndarray = field(init=False, repr=False)
    c: np.ndarray = field(init=False, repr=False)
    e: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        stages = len(self.nodes)
        dense = {
            "a": np.array([_dense(row, stages) for row in ({}, *self.rows)]),
            "b": _dense(self.weights, stages),
            "c": np.array(self.nodes),
            "e": np.array([_dense(row, stages) for row in self.errors]),
        }
        for name, value in dense.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        # The coefficients are given to 16 digits and reach 40 in size: sums are good to some 1e-14.
        self._check(np.abs(self.a.sum(axis=1) - self.c).max(), "a row does not sum to its node")
        self._check(np.abs(self.e.sum(axis=1)).max(), "an error estimator does not sum to zero")
        for power in range(1, self.order + 1):
            self._check(abs(self.b @ self.c ** (power - 1) - 1.0 / power), f"quadrature condition {power}")

    def _check(self, defect: float, what: str) -> None:
        if defect > 1e-13:
            raise ValueError(f"{self.name}: {what} (off by {defect:.1e})")


DOP853 = Tableau(
    name="DOP853",
    order=8,
    reference="Dormand and Prince, order 8(5,3); Hairer, Norsett and Wanner (1993), Solving ODE I, II.5 and II.10",
    nodes=(
        0.0,
        0.05260015195876773,
        0.0789002279381516,
        0.1183503419072274,
        0.2816496580927726,
        0.3333333333333333,
        0.25,
        0.3076923076923077,
        0.6512820512820513,
        0.6,
        0.8571428571428571,
        1.0,
    ),
    rows=(
        {0: 0.05260015195876773},
        {0: 0.0197250569845379, 1: 0.0591751709536137},
        {0: 0.02958758547680685, 2: 0.08876275643042054},
        {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
        {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
        {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
        {
            0: 0.03709200011850479,
            3: 0.17038392571223998,
            4: 0.10726203044637328,
            5: -0.015319437748624402,
            6: 0.008273789163814023,
        },
        {
            0: 0.6241109587160757,
            3: -3.3608926294469414,
            4: -0.868219346841726,
            5: 27.59209969944671,
            6: 20.154067550477894,
            7: -43.48988418106996,
        },
        {
            0: 0.47766253643826434,
            3: -2.4881146199716677,
            4: -0.590290826836843,
            5: 21.230051448181193,
            6: 15.279233632882423,
            7: -33.28821096898486,
            8: -0.020331201708508627,
        },
        {
            0: -0.9371424300859873,
            3: 5.186372428844064,
            4: 1.0914373489967295,
            5: -8.149787010746927,
            6: -18.52006565999696,
            7: 22.739487099350505,
            8: 2.4936055526796523,
            9: -3.0467644718982196,
        },
        {
            0: 2.273310147516538,
            3: -10.53449546673725,
            4: -2.0008720582248625,
            5: -17.9589318631188,
            6: 27.94888452941996,
            7: -2.8589982771350235,
            8: -8.87285693353063,
            9: 12.360567175794303,
            10: 0.6433927460157636,
        },
    ),
    weights={
        0: 0.054293734116568765,
        5: 4.450312892752409,
        6: 1.8915178993145003,
        7: -5.801203960010585,
        8: 0.3111643669578199,
        9: -0.1521609496625161,
        10: 0.20136540080403034,
        11: 0.04471061572777259,
    },
    errors=(
        {
            0: 0.01312004499419488,
            5: -1.2251564463762044,
            6: -0.4957589496572502,
            7: 1.6643771824549864,
            8: -0.35032884874997366,
            9: 0.3341791187130175,
            10: 0.08192320648511571,
            11: -0.022355307863886294,
        },
        {
            0: -0.18980075407240762,
            5: 4.450312892752409,
            6: 1.8915178993145003,
            7: -5.801203960010585,
            8: -0.4226823213237919,
            9: -0.1521609496625161,
            10: 0.20136540080403034,
            11: 0.02265179219836082,
        },
    ),
)
