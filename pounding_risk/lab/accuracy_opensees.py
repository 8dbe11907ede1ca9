"""Cases of an accuracy study in OpenSees, where it can say the same; openseespy is the extra `benchmark`.

Masses on zeroLength springs and dashpots, an impact material where floors meet; Newmark's average acceleration,
modified Newton, NormDispIncr 1e-12 (with a looser test a smaller step gives a worse answer: masses move less than
1e-6 m in one). Every impact is a line on standard error, which is silenced. Peaks are the largest values at the steps,
from envelope recorders; the time is that of `analyze` alone.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from itertools import product
from math import inf, log2
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError
from pounding_risk.lab.accuracy_bench import OPEN, Bench, Outcome, PointCase
from pounding_risk.lab.accuracy_findings import FORCE, GAP, OUTPUTS, REACH, YIELDS
from pounding_risk.lab.baselines.matrices import Array
from pounding_risk.models.contact.law import SLOWEST_TOUCH, snake_case
from pounding_risk.models.contact.laws import HertzDamp, Jankowski, KelvinVoigt
from pounding_risk.models.contact.laws.jankowski import jankowski_ratio
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.hysteresis.power_law import damping_at_rest
from pounding_risk.models.structures.links import LINK, Link
from pounding_risk.models.structures.mdof import Chain

HUGE = 1e15  # N, at which a hook would yield
OF_BRACE = 1e4  # 1/s: stiffness over damping at rest of a brace that gives as good as nothing
PLAIN = "ModifiedNewton"
NEAREST = 1e-12  # m: the impact materials refuse a gap of zero
TEST, ITERATIONS = 1e-12, 100  # m, and per step
GROUND = 1  # node; mass i is node i + 2
UNDAMPED = "-doRayleigh", 0
MATERIALS = tuple(law.__name__ for law in (Jankowski, HertzDamp, KelvinVoigt))  # laws that OpenSees has
FALLS = "it takes one e for every impact of a contact, not one that falls with the speed"
ON_SPRINGS = "a building on a foundation that rotates or slides is not built here"


class Peaks(NamedTuple):
    """Peaks of one run by contact point, and the processor's time for it."""

    relative_displacement: Array  # m
    closing: Array  # m
    contact_force: Array  # N
    seconds: float


def load() -> Any:
    """The module ``openseespy.opensees``; raises PoundingError, with the cause, where it cannot be loaded."""
    try:
        import openseespy.opensees as ops
    except (ImportError, OSError, RuntimeError) as error:
        # openseespy wraps the loader's own words in errors of its own, twice.
        cause: BaseException = error
        while (earlier := cause.__cause__ or cause.__context__) is not None:
            cause = earlier
        raise PoundingError(
            f'openseespy cannot be loaded ({cause}); `pip install "pounding-risk[benchmark]"` brings it, and on Debian '
            "it needs `apt-get install libblas3 liblapack3`"
        ) from None
    return ops


def unsaid(chains: Sequence[Chain], points: Sequence[Point], case: PointCase) -> str:
    """What of a row OpenSees cannot say; "" where it says the same."""
    kinds = {type(law).__name__ for law in case.laws} - set(MATERIALS)
    if kinds:
        return f"it has no material for {', '.join(sorted(kinds))}; it has Jankowski, HertzDamp and KelvinVoigt"
    if not has_constant_restitution(case.rules):
        return FALLS
    if any(floor != int(floor) for point in points for _, floor in sides_of(chains, point)):
        return "in one dimension it has no contact part-way up a column"
    if any(chain.foundations for chain in chains):
        return ON_SPRINGS
    if any(chain.twists for chain in chains):
        return "floors that rotate are not built here; `export --to opensees` writes them"
    if any(map(divides_by_rest, case.laws, case.gaps)):
        return (
            "Hertzdamp divides its damping by the speed of floors that begin at rest in touch, and fails or is 0.5 % "
            "off at any step; leave out the gap of zero"
        )
    return ""


class PowerLaw(NamedTuple):
    """A contact force in two powers, F = k δ^n + c δ^p δ̇, held between two values; in SI."""

    stiffness: float  # k
    exponent: float  # n
    damping: float  # c; of a law whose c falls with the speed at the touch, that of 1 m/s
    damping_exponent: float  # p
    on_approach: bool  # the damper acts on approach alone
    by_speed: bool  # c is divided by the speed at the touch
    least: float  # N, −inf where it may pull
    most: float  # N, inf without a cap

    def force(self, touch: float, delta: float, rate: float) -> float:
        """The force [N] at a penetration [m] and its rate [m/s], of a contact that began at ``touch`` [m/s]."""
        damping = self.damping / max(touch, SLOWEST_TOUCH) if self.by_speed else self.damping
        viscous = damping * delta**self.damping_exponent * rate if rate > 0.0 or not self.on_approach else 0.0
        return min(max(self.stiffness * delta**self.exponent + viscous, self.least), self.most)


def power_law(law: Any, e: float, mass: float, yield_force: float) -> PowerLaw | None:
    """A contact law without a path as the same force in two powers, within 1e-9; None for another.

    Read off the law itself at some places and compared at others, for a restitution ``e``, a striking mass [kg] and a
    yield force [N].
    """
    memory, slower = (float(law.begin(e, speed, mass)) for speed in (1.0, 0.5))
    elastic = [float(law.force(0.0, delta, 0.0, False)) for delta in (1.0, 2.0)]
    viscous = [float(law.force(memory, delta, 1.0, True)) - one for delta, one in zip((1.0, 2.0), elastic, strict=True)]
    if elastic[0] <= 0.0 or elastic[1] <= 0.0:
        return None
    is_damped = viscous[0] > 0.0 and viscous[1] > 0.0
    powers = PowerLaw(
        elastic[0],
        round(log2(elastic[1] / elastic[0]), 9),
        viscous[0] if is_damped else 0.0,
        round(log2(viscous[1] / viscous[0]), 9) if is_damped else 0.0,
        bool(law.force(memory, 1.0, -1.0, False) == elastic[0]),
        bool(abs(slower - 2.0 * memory) <= 1e-12 * abs(slower)),
        float(law.floor()),
        float(law.ceiling(yield_force)),
    )
    for touch, delta, rate in product((0.2, 1.3), (1e-4, 3e-3, 0.1), (-1.7, -0.2, 0.3, 2.0)):
        force = float(law.force(law.begin(e, touch, mass), delta, rate, rate > 0.0))
        force = float(law.plateau(delta, powers.most)) if force > powers.most else max(force, powers.least)
        if abs(powers.force(touch, delta, rate) - force) > 1e-9 * abs(force):
            return None
    return powers


def name_of(law: Any) -> str:
    """What scenes call a contact law."""
    return snake_case(type(law).__name__)


def has_constant_restitution(rules: Sequence[Any]) -> bool:
    """Whether restitution is the same at every speed."""
    return all(rule == constant(rule.c0) for rule in rules)


def sides_of(chains: Sequence[Chain], point: Point) -> list[tuple[int, float]]:
    """Building and floor of both sides of a contact point, without a rigid building."""
    sides = (point.interface, point.left_floor), (point.interface + 1, point.right_floor)
    return [(building, floor) for building, floor in sides if chains[building].mass.size]


def joins(matrix: Array) -> dict[tuple[int, int], float]:
    """Springs or dashpots between two floors of a building, 0 the ground, that make up any symmetric matrix."""
    count, smallest = len(matrix), 1e-14 * np.abs(matrix).max(initial=0.0)
    to_ground = {(0, j): float(matrix[j - 1].sum()) for j in range(1, count + 1)}
    between = {(i, j): -float(matrix[i - 1, j - 1]) for i in range(1, count + 1) for j in range(i + 1, count + 1)}
    return {pair: stiffness for pair, stiffness in (to_ground | between).items() if abs(stiffness) > smallest}


def impact_material(chains: Sequence[Chain], point: Point, contact: tuple[float, Any, Any]) -> tuple[Any, ...]:
    """The law of a contact point as OpenSees takes it after the tag: its name and numbers; lengths are negative there.

    ``contact`` is (gap [m], law, rule of restitution).
    """
    gap, law, rule = contact
    masses = [chains[building].mass[int(floor) - 1] for building, floor in sides_of(chains, point)]
    mass, e = float(1.0 / sum(1.0 / mass for mass in masses)), rule.c0
    open_gap = -max(float(gap), NEAREST)
    if isinstance(law, Jankowski):
        return "JankowskiImpact", law.stiffness, jankowski_ratio(e), mass, open_gap, 1.5
    if isinstance(law, HertzDamp):
        return "Hertzdamp", law.stiffness, law.begin(e, 1.0, mass), open_gap, 1.5
    return "ViscoelasticGap", law.stiffness, law.begin(e, 1.0, mass), open_gap


def divides_by_rest(law: Any, gap: float) -> bool:
    """Whether OpenSees' material divides its damping by the speed of floors that begin at rest in touch, gap in m.

    This package takes `SLOWEST_TOUCH` at least; Hertzdamp whatever it finds, such as 6e-9 m/s.
    """
    return isinstance(law, HertzDamp) and gap <= NEAREST


def storey_material(
    law: Hysteresis | None, stiffness: float, strength: float, hardening: float
) -> tuple[Any, ...] | None:
    """The law of a storey, or of isolators, as OpenSees takes it after the tag; None where it has none like it.

    ``law`` is None for a bilinear one.
    """
    limit = strength / stiffness
    points = [] if law is None else [(drift * limit, shear * strength) for drift, shear in law.backbone]
    rule = "kinematic" if law is None else law.rule
    if rule == "kinematic" and not points:
        return "Steel01", strength, stiffness, hardening
    if rule == "kinematic":
        last_point = 1e3 * points[-1][0], points[-1][1]
        return "MultiLinear", *(number for point in ((limit, strength), *points, last_point) for number in point)
    if rule == "isotropic" and not points:
        return "Hardening", stiffness, strength, stiffness * hardening / (1.0 - hardening), 0.0
    if law is not None and rule == "bouc_wen":
        gamma, beta = (share / limit**law.exponent for share in (1.0 - law.beta, law.beta))
        losses = (loss / (strength * limit) for loss in (law.delta_a, law.delta_nu, law.delta_eta))
        return "BoucWen", hardening, stiffness, law.exponent, gamma, beta, 1.0, *losses, 1e-10, 100
    # Three points; past the last one OpenSees goes on, unless it falls.
    is_trilinear = len(points) == 2 and points[1][1] < points[0][1] and law is not None and law.energy_capacity == inf
    if rule != "peak_oriented" or law is None or not is_trilinear:
        return None
    envelope = [number for drift, shear in ((limit, strength), *points) for number in (shear, drift)]
    pinching = law.pinching_drift, law.pinching_force
    return "Hysteretic", *envelope, *(-number for number in envelope), *pinching, 0.0, 0.0, law.unloading


def link_material(link: Link) -> tuple[Any, ...]:
    """The spring of a link as OpenSees takes it after the tag."""
    if link.stiffness and link.strength < inf:
        return "ElasticPP", link.stiffness, link.strength / link.stiffness
    if link.stiffness and link.slack > -inf:
        return "ElasticPPGap", link.stiffness, HUGE, max(link.slack, NEAREST)
    return "Elastic", link.stiffness


def algorithm(yielding: Iterable[Any], links: Iterable[Link]) -> str:
    """The algorithm of OpenSees for storeys and links whose tangents change by more than an impact's."""
    laws = [link for link in links if link.law]
    if any(link.exponent not in (0.0, 1.0) or link.is_braced for link in laws):
        return "KrylovNewton"
    return "Newton" if laws or any(yielding) else PLAIN


def link_dashpot(link: Link) -> tuple[Any, ...]:
    """The damper of a link as OpenSees takes it after the tag."""
    if link.is_braced:
        return "ViscousDamper", link.brace, link.damping, link.exponent
    if link.exponent not in (0.0, 1.0):
        brace = OF_BRACE * max(damping_at_rest(link.damping, link.exponent), link.damping)
        return "ViscousDamper", brace, link.damping, link.exponent
    return "Elastic", 0.0, link.damping


def storeys_of(bench: Bench, building: int) -> dict[int, Any]:
    """Materials of the storeys of a building that yield, by floor; None of one that OpenSees has not."""
    chain, structure = bench.chains[building], bench.study.buildings[building]
    hardening = np.broadcast_to(chain.hardening, chain.mass.size)
    base = 1 if getattr(structure, "isolators", None) else 0
    materials = {}
    for storey in np.flatnonzero(np.isfinite(chain.strength)).tolist():
        law = None if storey - chain.foundations < base else getattr(structure, "hysteresis", None)
        numbers = chain.shear[storey], chain.strength[storey], hardening[storey]
        materials[storey + 1] = storey_material(law, *map(float, numbers))
    return materials


def beside(chain: Chain, materials: Mapping[int, Any]) -> list[float]:
    """Stiffness of each storey [N/m]; of one with a material of `storeys_of` what P-Δ takes, beside that material."""
    pairs = zip(chain.spring.tolist(), chain.shear.tolist(), strict=True)
    return [spring - shear if floor in materials else spring for floor, (spring, shear) in enumerate(pairs, start=1)]


def unsaid_laws(bench: Bench) -> str:
    """What of a scene's buildings and links OpenSees has nothing for; "" where it has all."""
    if bench.opensees_lacks:
        return f"it knows no {bench.opensees_lacks}"
    if any(link.breaking < inf for link in bench.study.links):
        return "links that break are not written"
    for building, structure in enumerate(bench.study.buildings):
        if None in storeys_of(bench, building).values():
            return f"it has no material like the hysteresis of {structure.name}"
    return ""


class _Model:
    """Nodes and elements of a row, numbered in the order in which they are added; a rigid building is the ground."""

    def __init__(self, ops: Any) -> None:
        self.ops, self.tag, self.masses = ops, GROUND, 0
        self.nodes: dict[tuple[int, int], int] = {}  # by building and floor
        ops.wipe()
        ops.model("basic", "-ndm", 1, "-ndf", 1)
        ops.node(GROUND, 0.0)
        ops.fix(GROUND, 1)

    def join(self, ends: Sequence[int], material: Sequence[Any], *options: Any) -> int:
        """The element between two nodes with a material: its name, then its numbers."""
        self.tag += 1
        name, *numbers = material
        self.ops.uniaxialMaterial(name, self.tag, *numbers)
        self.ops.element("zeroLength", self.tag, *ends, "-mat", self.tag, "-dir", 1, *options)
        return self.tag

    def ends(self, place: Link | Point) -> tuple[int, int]:
        """The nodes that a link or a contact joins."""
        left, right = (place.interface, int(place.left_floor)), (place.interface + 1, int(place.right_floor))
        return self.nodes.get(left, GROUND), self.nodes.get(right, GROUND)

    def add_building(self, building: int, chain: Chain, materials: dict[int, Any]) -> None:
        """Masses, springs and dashpots, and the ``materials`` of storeys that yield."""
        self.nodes[building, 0] = GROUND
        for floor, mass in enumerate(chain.mass.tolist(), start=1):
            self.masses += 1
            self.nodes[building, floor] = self.masses + 1
            self.ops.node(self.masses + 1, 0.0)
            self.ops.mass(self.masses + 1, mass)
        for floor, material in materials.items():
            self.join((self.nodes[building, floor - 1], self.nodes[building, floor]), material, *UNDAMPED)
        springs = {(floor, floor + 1): spring for floor, spring in enumerate(beside(chain, materials))}
        dashpots, couplings = joins(chain.damping), joins(chain.coupling)
        for pair in {**springs, **couplings, **dashpots}:
            spring = springs.get(pair, 0.0) + couplings.get(pair, 0.0)
            nodes = [self.nodes[building, floor] for floor in pair]
            self.join(nodes, ("Elastic", spring, dashpots.get(pair, 0.0)), *UNDAMPED)


def build(
    ops: Any,
    chains: Sequence[Chain],
    points: Sequence[Point],
    case: PointCase,
    motion: Any,
    links: Sequence[Link] = (),
    yielding: Sequence[dict[int, Any]] = (),
) -> list[int]:
    """Nodes, springs, dashpots, links, contacts, the ground motion and the method; returns the contacts' elements.

    A ``motion`` has its acceleration and ``dt``; ``yielding`` are `storeys_of` each building.
    """
    model = _Model(ops)
    for building, chain in enumerate(chains):
        model.add_building(building, chain, yielding[building] if yielding else {})
    for link in links:
        model.join(model.ends(link), link_material(link), *UNDAMPED)
        model.join(model.ends(link), link_dashpot(link), *UNDAMPED)
    elements = [
        model.join(model.ends(point), impact_material(chains, point, (case.gaps[k], case.laws[k], case.rules[k])))
        for k, point in enumerate(points)
        if point.kind != LINK
    ]
    shake(ops, motion.acceleration, motion.dt, range(2, model.masses + 2))
    ops.algorithm(algorithm(yielding, links))
    return elements


def shake(ops: Any, acceleration: NDArray[Any], dt: float, nodes: Iterable[int], numberer: str = "RCM") -> None:
    """The ground motion under some nodes at rest, and the method."""
    ops.timeSeries("Path", 1, "-dt", dt, "-values", *acceleration.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    for node in nodes:
        # At rest the first sample acts already; Newmark's rule would start from none and lose an order.
        ops.setNodeAccel(node, 1, -float(acceleration[0]), "-commit")
    ops.constraints("Plain")
    ops.numberer(numberer)
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", TEST, ITERATIONS)
    ops.algorithm(PLAIN)
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def solve(bench: Bench, case: PointCase, h: float) -> Peaks:
    """One run from rest with steps of ``h`` [s].

    Raises PoundingError where openseespy cannot be loaded or cannot say the same, or a step does not converge.
    """
    if reason := unsaid(bench.chains, bench.points, case):
        raise PoundingError(reason)
    ops, motion = load(), bench.motions[case.motion]
    duration = (len(motion.acceleration) - 1) * motion.dt
    with TemporaryDirectory() as folder, silenced():
        yielding = [storeys_of(bench, building) for building in range(len(bench.chains))]
        elements = build(ops, bench.chains, bench.points, case, motion, bench.study.links, yielding)
        files = [os.path.join(folder, name) for name in ("reach", "force")]
        for file, response in zip(files, (("deformation",), ("material", 1, "stress")), strict=True):
            ops.recorder("EnvelopeElement", "-file", file, "-precision", 17, "-ele", *elements, *response)
        begun = process_time()
        failed = ops.analyze(round(duration / h), h)
        seconds = process_time() - begun
        end_time = ops.getTime()
        ops.wipe()  # closes the recorders' files
        # Rows: smallest, largest, largest in size.
        reach, force = (np.loadtxt(Path(file), ndmin=2) for file in files)
    if failed:
        raise PoundingError(f"no convergence in {ITERATIONS} iterations at {end_time:.4g} s of {duration:g} s")
    # The deformation is that of the right node beyond the left one.
    peaks = np.zeros((3, len(bench.points)))
    peaks[:, list(bench.contact_points)] = np.abs(reach).max(axis=0), np.maximum(-reach[0], 0.0), -force[0]
    return Peaks(peaks[0], peaks[1], peaks[2], seconds)


def hindrance(bench: Bench) -> str:
    """Why OpenSees cannot run the cases of a bench; "" where it can."""
    if reason := unsaid_laws(bench):
        return reason
    for case in bench.point_cases():
        if reason := unsaid(bench.chains, bench.points, case):
            return reason
    try:
        load()
    except PoundingError as error:
        return str(error)
    return ""


def opensees_outcome(bench: Bench, dt: float) -> Outcome:
    """All cases in OpenSees, in steps of about ``dt`` [s], a whole number of them a sample.

    It has neither counts nor the moment of the first touch. Raises PoundingError as `solve`.
    """
    cases, required, free_seconds = list(bench.point_cases()), [], 0.0
    steps = [motion.dt / max(1, round(motion.dt / dt)) for motion in bench.motions]
    for number, h in enumerate(steps):
        free = solve(bench, cases[0]._replace(motion=number, gaps=np.full(len(bench.points), OPEN)), h)
        required.append(bench.of_interfaces(np.maximum, free.closing))
        free_seconds += free.seconds
    outputs, seconds = np.full((len(cases), len(required[0]), len(OUTPUTS)), np.nan), 0.0
    for number, case in enumerate(cases):
        peaks = solve(bench, case, steps[case.motion])
        seconds += peaks.seconds
        by_point = peaks.relative_displacement, peaks.contact_force, peaks.contact_force >= case.yield_forces
        for output, points in zip((REACH, FORCE, YIELDS), by_point, strict=True):
            outputs[number, :, output] = bench.of_interfaces(np.maximum, points)
        outputs[number, :, GAP] = required[case.motion]
    times = seconds / len(cases), free_seconds / len(bench.motions)
    return Outcome(outputs, np.nan, np.nan, *times, outputs=(REACH, FORCE, YIELDS, GAP))


@contextmanager
def silenced() -> Iterator[None]:
    """No output from compiled code, neither on the streams of Python, as in a notebook, nor on those of the system."""
    sys.stdout.flush()
    sys.stderr.flush()
    streams = os.dup(1), os.dup(2)
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        try:
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)
            yield
        finally:
            for number, stream in enumerate(streams, start=1):
                os.dup2(stream, number)
                os.close(stream)
