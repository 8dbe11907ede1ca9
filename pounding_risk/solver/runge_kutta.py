"""The Runge-Kutta methods of the contact phase, as tables that check themselves: explicit ones and an implicit one."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

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
    error estimators (each sums to zero). For values between the ends of a step, ``between`` has up to four rows of
    coefficients (Hairer's continuous extension; none leaves the cubic through both ends), for which the stages
    ``late_rows`` at ``late_nodes`` may be needed. Columns count the stages, then the slope at the end of the step,
    then the late stages. Checked: row sums equal the nodes, Σ b = 1, the quadrature conditions Σ b c^(q−1) = 1/q up
    to the order, and that the rows between the ends add nothing to a motion of constant slope.
    """

    name: str
    order: int
    reference: str
    nodes: tuple[float, ...]
    rows: tuple[dict[int, float], ...]
    weights: dict[int, float]
    errors: tuple[dict[int, float], ...]
    late_nodes: tuple[float, ...] = ()
    late_rows: tuple[dict[int, float], ...] = ()
    between: tuple[dict[int, float], ...] = ()
    a: np.ndarray = field(init=False, repr=False)
    b: np.ndarray = field(init=False, repr=False)
    c: np.ndarray = field(init=False, repr=False)
    e: np.ndarray = field(init=False, repr=False)
    late: np.ndarray = field(init=False, repr=False)
    d: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        stages = len(self.nodes)
        columns = stages + 1 + len(self.late_nodes)
        dense = {
            "a": np.array([_dense(row, stages) for row in ({}, *self.rows)]),
            "b": _dense(self.weights, stages),
            "c": np.array(self.nodes),
            "e": np.array([_dense(row, stages + 1) for row in self.errors]),
            "late": np.array([_dense(row, columns) for row in self.late_rows]).reshape(-1, columns),
            "d": np.array([_dense(row, columns) for row in self.between]).reshape(-1, columns),
        }
        for name, value in dense.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        # The coefficients are given to 16 digits and reach 40 in size: sums are good to some 1e-14.
        self._check(np.abs(self.a.sum(axis=1) - self.c).max(), "a row does not sum to its node")
        self._check(np.abs(self.e.sum(axis=1)).max(), "an error estimator does not sum to zero")
        self._check(
            np.abs(self.late.sum(axis=1) - self.late_nodes).max(initial=0.0), "a late row does not sum to its node"
        )
        self._check(1e-2 * np.abs(self.d.sum(axis=1)).max(initial=0.0), "a row between the ends does not sum to zero")
        for power in range(1, self.order + 1):
            self._check(abs(self.b @ self.c ** (power - 1) - 1.0 / power), f"quadrature condition {power}")

    def _check(self, defect: float, condition: str) -> None:
        if defect > 1e-13:
            raise ValueError(f"{self.name}: {condition} (off by {defect:.1e})")


DOP853 = Tableau(
    name="DOP853",
    order=8,
    reference="Dormand and Prince, order 8(5,3); Hairer, Norsett and Wanner (1993), Solving ODE I, II.5 and II.10",
    nodes=(
        0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 0.3333333333333333, 0.25,
        0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0,
    ),
    rows=(
        {0: 0.05260015195876773},
        {0: 0.0197250569845379, 1: 0.0591751709536137},
        {0: 0.02958758547680685, 2: 0.08876275643042054},
        {0: 0.2413651341592667, 2: -0.8845494793282861, 3: 0.924834003261792},
        {0: 0.037037037037037035, 3: 0.17082860872947386, 4: 0.12546768756682242},
        {0: 0.037109375, 3: 0.17025221101954405, 4: 0.06021653898045596, 5: -0.017578125},
        {0: 0.03709200011850479, 3: 0.17038392571223998, 4: 0.10726203044637328, 5: -0.015319437748624402,
         6: 0.008273789163814023},
        {0: 0.6241109587160757, 3: -3.3608926294469414, 4: -0.868219346841726, 5: 27.59209969944671,
         6: 20.154067550477894, 7: -43.48988418106996},
        {0: 0.47766253643826434, 3: -2.4881146199716677, 4: -0.590290826836843, 5: 21.230051448181193,
         6: 15.279233632882423, 7: -33.28821096898486, 8: -0.020331201708508627},
        {0: -0.9371424300859873, 3: 5.186372428844064, 4: 1.0914373489967295, 5: -8.149787010746927,
         6: -18.52006565999696, 7: 22.739487099350505, 8: 2.4936055526796523, 9: -3.0467644718982196},
        {0: 2.273310147516538, 3: -10.53449546673725, 4: -2.0008720582248625, 5: -17.9589318631188,
         6: 27.94888452941996, 7: -2.8589982771350235, 8: -8.87285693353063, 9: 12.360567175794303,
         10: 0.6433927460157636},
    ),
    weights={
        0: 0.054293734116568765, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
        8: 0.3111643669578199, 9: -0.1521609496625161, 10: 0.20136540080403034, 11: 0.04471061572777259,
    },
    errors=(
        {0: 0.01312004499419488, 5: -1.2251564463762044, 6: -0.4957589496572502, 7: 1.6643771824549864,
         8: -0.35032884874997366, 9: 0.3341791187130175, 10: 0.08192320648511571, 11: -0.022355307863886294},
        {0: -0.18980075407240762, 5: 4.450312892752409, 6: 1.8915178993145003, 7: -5.801203960010585,
         8: -0.4226823213237919, 9: -0.1521609496625161, 10: 0.20136540080403034, 11: 0.02265179219836082},
    ),
    late_nodes=(0.1, 0.2, 0.7777777777777778),
    late_rows=(
        {0: 0.056167502283047954, 6: 0.25350021021662483, 7: -0.2462390374708025, 8: -0.12419142326381637,
         9: 0.15329179827876568, 10: 0.00820105229563469, 11: 0.007567897660545699, 12: -0.008298},
        {0: 0.03183464816350214, 5: 0.028300909672366776, 6: 0.053541988307438566, 7: -0.05492374857139099,
         10: -0.00010834732869724932, 11: 0.0003825710908356584, 12: -0.00034046500868740456, 13: 0.1413124436746325},
        {0: -0.42889630158379194, 5: -4.697621415361164, 6: 7.683421196062599, 7: 4.06898981839711,
         8: 0.3567271874552811, 12: -0.0013990241651590145, 13: 2.9475147891527724, 14: -9.15095847217987},
    ),
    between=(
        {0: -8.428938276109013, 5: 0.5667149535193777, 6: -3.0689499459498917, 7: 2.38466765651207,
         8: 2.117034582445028, 9: -0.871391583777973, 10: 2.2404374302607883, 11: 0.6315787787694688,
         12: -0.08899033645133331, 13: 18.148505520854727, 14: -9.194632392478356, 15: -4.436036387594894},
        {0: 10.427508642579134, 5: 242.28349177525817, 6: 165.20045171727028, 7: -374.5467547226902,
         8: -22.113666853125306, 9: 7.733432668472264, 10: -30.674084731089398, 11: -9.332130526430229,
         12: 15.697238121770845, 13: -31.139403219565178, 14: -9.35292435884448, 15: 35.81684148639408},
        {0: 19.985053242002433, 5: -387.0373087493518, 6: -189.17813819516758, 7: 527.8081592054236,
         8: -11.57390253995963, 9: 6.8812326946963, 10: -1.0006050966910838, 11: 0.7777137798053443,
         12: -2.778205752353508, 13: -60.19669523126412, 14: 84.32040550667716, 15: 11.99229113618279},
        {0: -25.69393346270375, 5: -154.18974869023643, 6: -231.5293791760455, 7: 357.6391179106141,
         8: 93.40532418362432, 9: -37.45832313645163, 10: 104.0996495089623, 11: 29.8402934266605,
         12: -43.53345659001114, 13: 96.32455395918828, 14: -39.17726167561544, 15: -149.72683625798564},
    ),
)  # fmt: skip

DORMAND_PRINCE = Tableau(
    "Dormand-Prince 5(4)",
    5,
    "Dormand & Prince (1980), J. Comput. Appl. Math. 6, 19-26; between the ends: Hairer, Nørsett & Wanner (1993)",
    nodes=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0),
    rows=(
        {0: 1 / 5},
        {0: 3 / 40, 1: 9 / 40},
        {0: 44 / 45, 1: -56 / 15, 2: 32 / 9},
        {0: 19372 / 6561, 1: -25360 / 2187, 2: 64448 / 6561, 3: -212 / 729},
        {0: 9017 / 3168, 1: -355 / 33, 2: 46732 / 5247, 3: 49 / 176, 4: -5103 / 18656},
    ),
    weights={0: 35 / 384, 2: 500 / 1113, 3: 125 / 192, 4: -2187 / 6784, 5: 11 / 84},
    errors=({0: -71 / 57600, 2: 71 / 16695, 3: -71 / 1920, 4: 17253 / 339200, 5: -22 / 525, 6: 1 / 40},),
    between=(
        {
            0: -12715105075 / 11282082432,
            2: 87487479700 / 32700410799,
            3: -10690763975 / 1880347072,
            4: 701980252875 / 199316789632,
            5: -1453857185 / 822651844,
            6: 69997945 / 29380423,
        },
    ),
)


@dataclass(frozen=True)
class Collocation:
    """An implicit Runge-Kutta method whose steps are polynomials: their slopes are right at every node.

    Its arrays follow from the nodes, exactly up to the last rounding. ``a`` (stages, stages) are the stage
    coefficients, whose last row is also the weights: the last node is the end of the step. ``start`` (stages) is the
    slope at the beginning of the step that the slopes at the nodes imply. ``terms`` (stages, stages) makes, of the
    changes up to every node, the P of y = y0 + x (P0 + (1−x) (P1 + x (P2 + ...))). Refuses nodes that do not make the
    order: ∫ of every power below it over the step must come out.
    """

    name: str
    order: int
    reference: str
    nodes: tuple[float, ...]
    a: np.ndarray = field(init=False, repr=False)
    c: np.ndarray = field(init=False, repr=False)
    start: np.ndarray = field(init=False, repr=False)
    terms: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        nodes = [Fraction(node) for node in self.nodes]
        basis = [_through(nodes, number) for number in range(len(nodes))]
        dense = {
            "a": [[float(_integral(polynomial, node)) for polynomial in basis] for node in nodes],
            "c": self.nodes,
            "start": [float(polynomial[0]) for polynomial in basis],
            "terms": np.linalg.inv([[_nested(float(node), term) for term in range(len(nodes))] for node in nodes]),
        }
        for name, value in dense.items():
            array = np.ascontiguousarray(value, dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.nodes[-1] != 1.0:
            raise ValueError(f"{self.name}: the last node is not the end of the step")
        for power in range(1, self.order + 1):
            defect = abs(self.a[-1] @ self.c ** (power - 1) - 1.0 / power)
            if defect > 1e-15:
                raise ValueError(f"{self.name}: quadrature condition {power} (off by {defect:.1e})")


def _through(nodes: list[Fraction], number: int) -> list[Fraction]:
    """Coefficients, lowest power first, of the polynomial that is 1 at one of the nodes and 0 at the others."""
    coefficients = [Fraction(1)]
    for other, node in enumerate(nodes):
        if other != number:
            rise, constant_part = [Fraction(0), *coefficients], [*coefficients, Fraction(0)]
            reach = nodes[number] - node
            coefficients = [(high - node * low) / reach for high, low in zip(rise, constant_part, strict=True)]
    return coefficients


def _integral(coefficients: list[Fraction], end: Fraction) -> Fraction:
    """Integral of a polynomial, lowest power first, from 0 to ``end``."""
    return sum((value * end ** (n + 1) / (n + 1) for n, value in enumerate(coefficients)), Fraction(0))


def _nested(x: float, term: int) -> float:
    """What P of this number is multiplied with at x in `Collocation`: x (1−x) x (1−x) ..."""
    return x ** (1 + term // 2) * (1.0 - x) ** ((term + 1) // 2)


RADAU = Collocation(
    name="Radau IIA, five stages",
    order=9,
    reference="Hairer and Wanner (1996), Solving ODE II, IV.5 and IV.8",
    nodes=(0.05710419611451768, 0.2768430136381238, 0.5835904323689168, 0.8602401356562195, 1.0),
)
