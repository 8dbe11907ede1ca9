"""A scene as a commented OpenSeesPy script that runs by itself, with the peaks of this package to hold it against."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import isfinite
from pathlib import Path
from pprint import pformat
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk._common.version import __version__
from pounding_risk._common.words import listed
from pounding_risk._common.written import write_file
from pounding_risk.errors import SceneError
from pounding_risk.motions.levels import at_pga
from pounding_risk.reports.exports import Options, Written

if TYPE_CHECKING:
    from pounding_risk.lab.accuracy_bench import Bench, PointCase
    from pounding_risk.lab.accuracy_opensees import PowerLaw
    from pounding_risk.scene.scene import Scene

WORDS = "a scene as an OpenSeesPy script"
ENDINGS = (".py",)
SOURCE = "scene"
TAKES = ("gap", "pga")
STEPS_A_SAMPLE = 10  # of the script, by default
WIDEST = 118  # characters of a line
RTOL = 1e-10  # of the peaks that the script shows beside its own

TEMPLATE = '''"""{title}, in OpenSeesPy.

{case}.

Written by pounding-risk {version}.
Units are N, kg, m and s; displacements are relative to the ground. Run it with
`python {name} [STEP]`, where STEP is the time step in s ({step:g} by default); it needs openseespy. Its error falls
with the step: compare two. What the scene has and this script has not, or does in another way:
{notes}
"""

import sys
from math import inf

import openseespy.opensees as ops

STEP = float(sys.argv[1]) if len(sys.argv) > 1 else {step!r}

# Of each building, from the ground up: mass of a floor [kg], and stiffness of the storey below it [N/m]. Floors that
# rotate are counted twice, all displacements before all rotations, with moments of inertia [kg m2] as masses.
BUILDINGS = {buildings}

# Numbers of the rotations among these, which the ground does not move.
ROTATIONS = {rotations}

# Storeys that yield: material and numbers by floor; the stiffness above is then what acts beside it.
YIELDING = {yielding}

# Springs between two floors of a building [N/m], beside its storeys, that make up its stiffness matrix; floor 0 is the
# ground.
SPRINGS = {springs}

# Dashpots between two floors of a building [N s/m] that make up its damping matrix; floor 0 is the ground.
DASHPOTS = {dashpots}

# Links between neighbours: (building, floor) at both ends, and materials of the spring and of the damper with
# their numbers.
LINKS = {links}

# Of each contact: (building, floor) on its left and right, and the impact material with its numbers; OpenSees measures
# lengths in contact as negative. A gap of zero is 1e-12 m, since the materials refuse it. None is the ground: a rigid
# building moves with it.
CONTACTS = {contacts}

# Contacts that OpenSees has no element or no material for. The closing of one is the sum of share times displacement
# over (building, floor, share); a floor against a column has two floors of a building, the end of a face that rotates
# a displacement and a rotation, whose share is an arm [m]. Penetration d is what exceeds the gap [m], v its rate. The
# force, stiffness d**exponent + damping d**damping_exponent v, lies between least and most [N]. The damper acts on
# approach only where on_approach is True, and its damping is divided by the speed at the touch where by_speed is True.
COMPUTED = {computed}

# Peaks that pounding-risk computes for the same scene: relative displacement [m] and contact force [N].
PEAKS = {peaks}

# Ground acceleration [m/s2] at equal time steps [s], linear in between.
SAMPLING = {sampling!r}
MOTION = {motion}

GROUND = 1
ops.wipe()
ops.model("basic", "-ndm", 1, "-ndf", 1)
ops.node(GROUND, 0.0)
ops.fix(GROUND, 1)

# A mass is a node; storeys and dashpots are elements without length.
node_of = {{None: GROUND}}
tag = GROUND


def join_by(one, other, material, *numbers):
    global tag
    tag += 1
    ops.uniaxialMaterial(material, tag, *numbers)
    ops.element("zeroLength", tag, one, other, "-mat", tag, "-dir", 1, "-doRayleigh", 0)


def join(one, other, stiffness, dashpot):
    join_by(one, other, "Elastic", stiffness, dashpot)


weight = {{}}  # mass of each node that the ground motion acts on [kg]
for building, storeys in BUILDINGS.items():
    node_of[building, 0] = GROUND
    for floor, (mass, stiffness) in enumerate(storeys, start=1):
        tag += 1
        node_of[building, floor] = tag
        ops.node(tag, 0.0)
        ops.mass(tag, mass)
        if floor not in ROTATIONS.get(building, ()):
            weight[tag] = mass
        if stiffness:
            join(node_of[building, floor - 1], node_of[building, floor], stiffness, 0.0)
    for floor, material in YIELDING[building].items():
        join_by(node_of[building, floor - 1], node_of[building, floor], *material)
    for (one, other), stiffness in SPRINGS[building].items():
        join(node_of[building, one], node_of[building, other], stiffness, 0.0)
    for (one, other), dashpot in DASHPOTS[building].items():
        join(node_of[building, one], node_of[building, other], 0.0, dashpot)

for left, right, spring, damper in LINKS:
    join_by(node_of[left], node_of[right], *spring)
    join_by(node_of[left], node_of[right], *damper)

elements = {{}}
for name, (left, right, (material, *numbers)) in CONTACTS.items():
    tag += 1
    ops.uniaxialMaterial(material, tag, *numbers)
    ops.element("zeroLength", tag, node_of[left], node_of[right], "-mat", tag, "-dir", 1)
    elements[name] = tag

ops.timeSeries("Path", 1, "-dt", SAMPLING, "-values", *MOTION)
ops.pattern("Plain", 1, 1)
# At rest the first sample acts already, where Newmark's rule would begin without it.
for node, mass in weight.items():
    ops.load(node, -mass)
    ops.setNodeAccel(node, 1, -MOTION[0], "-commit")
ops.timeSeries("Constant", 2)

# Newmark's average acceleration. The test is tight, as masses move less than 1e-6 m in a short step.
ops.constraints("Plain")
ops.numberer("RCM")
ops.system("ProfileSPD")
ops.test("NormDispIncr", 1e-12, 100)
ops.algorithm({algorithm!r})
ops.integrator("Newmark", 0.5, 0.25)
ops.analysis("Transient")


def across(contact, response):
    return sum(share * response(node_of[building, floor], 1) for building, floor, share in contact["ends"])


def force_ahead(contact):
    """The force at the end of the next step, from displacement and velocity that a constant acceleration gives."""
    speed, growth = across(contact, ops.nodeVel), across(contact, ops.nodeAccel)
    depth = across(contact, ops.nodeDisp) + STEP * speed + 0.5 * STEP**2 * growth - contact["gap"]
    rate = speed + STEP * growth
    if depth <= 0.0:
        contact["touch"] = None
        return 0.0
    if contact.get("touch") is None:
        contact["touch"] = max(rate, {slowest!r})
    damping = contact["damping"] / (contact["touch"] if contact["by_speed"] else 1.0)
    if contact["on_approach"] and rate <= 0.0:
        damping = 0.0
    force = contact["stiffness"] * depth ** contact["exponent"] + damping * depth ** contact["damping_exponent"] * rate
    return min(max(force, contact["least"]), contact["most"])


reach = dict.fromkeys([*CONTACTS, *COMPUTED], 0.0)
force = dict.fromkeys(reach, 0.0)
pressed = {{}}
for step in range(round((len(MOTION) - 1) * SAMPLING / STEP)):
    if pressed:
        ops.remove("loadPattern", 2)
    pressed = {{name: ahead for name, contact in COMPUTED.items() if (ahead := force_ahead(contact))}}
    if pressed:
        ops.pattern("Plain", 2, 2)
        for name, ahead in pressed.items():
            for building, floor, share in COMPUTED[name]["ends"]:
                ops.load(node_of[building, floor], -share * ahead)
    if ops.analyze(1, STEP):
        sys.exit(f"no convergence at {{ops.getTime():.4g}} s; try a shorter step")
    for name, element in elements.items():
        reach[name] = max(reach[name], abs(ops.eleResponse(element, "deformation")[0]))
        force[name] = max(force[name], -ops.eleResponse(element, "material", 1, "stress")[0])
    for name, contact in COMPUTED.items():
        reach[name] = max(reach[name], abs(across(contact, ops.nodeDisp)))
        force[name] = max(force[name], pressed.get(name, 0.0))

print(f"{{'contact':40}} {{'peak relative displacement [m]':>32}} {{'peak contact force [N]':>26}}")
for name in reach:
    print(f"{{name:40}} {{reach[name]:32.9g}} {{force[name]:26.9g}}")
print("pounding-risk")
for name, (moved, most) in PEAKS.items():
    print(f"{{name:40}} {{moved:32.9g}} {{most:26.9g}}")
'''


def write(study: Scene, target: Path, options: Options) -> Written:
    """Write the case of the scene's own gap under its first motion; raises SceneError for what OpenSees cannot say."""
    from pounding_risk.lab.accuracy_bench import bench_of
    from pounding_risk.lab.accuracy_opensees import SLOWEST_TOUCH, algorithm
    from pounding_risk.scene.scene import own_amplitude

    grid = study.grid
    own_case = grid._replace(
        gaps=(study.gap if options.gap is None else options.gap,),
        amplitudes=(at_pga(options.pga) or own_amplitude(study),),
        yield_forces=(study.yield_force,),
        contact_models=(study.contact_model,),
    )
    bench = bench_of(study.updated(grid=own_case), 1)
    script = _script(study, bench)
    notes = tuple(_notes(script))
    motion, tables = next(iter(bench.motions)), _parts(script)
    text = TEMPLATE.format(
        title=_in_text(study.name or "A scene"),
        case=_in_text(fill(bench.labels[0], WIDEST - 1)),
        version=__version__,
        name=_in_text(target.name),
        step=motion.dt / STEPS_A_SAMPLE,
        notes=_in_text("\n".join(fill(f"- {sentence}", WIDEST, subsequent_indent="  ") for sentence in notes)),
        sampling=motion.dt,
        slowest=SLOWEST_TOUCH,
        algorithm=algorithm(tables["yielding"].values(), study.links),
        motion=_listed(motion.acceleration.tolist()),
        **{name: pformat(table, sort_dicts=False, width=WIDEST - len(f"{name} = ")) for name, table in tables.items()},
    )
    return Written((write_file(target, text),), notes)


def _in_text(text: str) -> str:
    """Words of a scene within three quotes, which they neither end nor escape."""
    return text.replace("\\", "\\\\").replace('"""', "'''")


def _listed(numbers: list[float]) -> str:
    """Numbers in lines of a script, in full."""
    rows = (numbers[start : start + 4] for start in range(0, len(numbers), 4))
    body = "".join(f"    {', '.join(map(repr, row))},\n" for row in rows)
    return f"[\n{body}]"


class Script(NamedTuple):
    """A scene's first case as the script has it."""

    bench: Bench
    case: PointCase
    names: list[str]  # of the buildings
    computed: dict[int, PowerLaw]  # of contact points without a material, whose force the script computes

    def ends(self, k: int) -> list[tuple[str, int, float]]:
        """Building, floor and share of each mass in the displacement that closes a contact point."""
        first, shares = self.bench.at_rest.first, self.bench.at_rest.shares[k]
        masses = np.flatnonzero(shares)
        at = np.searchsorted(first, masses, side="right") - 1
        return [
            (self.names[building], int(mass - first[building] + 1), float(shares[mass]))
            for building, mass in zip(at, masses, strict=True)
        ]


def _script(study: Scene, bench: Bench) -> Script:
    """The first case; raises SceneError for what OpenSees cannot say, and a script cannot compute."""
    from pounding_risk.lab import accuracy_opensees as opensees

    case = next(bench.point_cases())
    fault = opensees.unsaid_laws(bench)
    fault = fault or (opensees.ON_SPRINGS if any(chain.foundations for chain in bench.chains) else "")
    fault = fault or ("" if opensees.has_constant_restitution(case.rules) else opensees.FALLS)
    computed: dict[int, PowerLaw] = {}
    loose = [link for link in study.links if link.left_floor % 1.0 or link.right_floor % 1.0]
    fault = fault or ("a link part-way up a column has no node to join" if loose else "")
    for k, point in bench.contact_points.items() if not fault else ():
        law, is_at_floors = case.laws[k], all(f == int(f) for _, f in opensees.sides_of(bench.chains, point))
        has_element = is_at_floors and not isfinite(point.across)
        has_material = type(law).__name__ in opensees.MATERIALS and not opensees.divides_by_rest(law, case.gaps[k])
        if has_element and has_material:
            continue
        numbers = opensees.power_law(law, case.rules[k].c0, bench.at_rest.striking[k], case.yield_forces[k])
        if numbers is None:
            fault = (
                f"it has no material for {opensees.name_of(law)}, whose force is no sum of two powers of the "
                "penetration that a script could compute; take one of jankowski, hertz_damp, kelvin_voigt or "
                "viscous_elastoplastic (--set interface.contact_model=...)"
            )
            break
        computed[k] = numbers
    if fault:
        raise SceneError(study.source, [f"OpenSees cannot say this scene: {fault}"])
    return Script(bench, case, [building.name for building in study.buildings], computed)


def _parts(script: Script) -> dict[str, Any]:
    """The numbers of the script, by their place in the template."""
    from pounding_risk.lab import accuracy_opensees as opensees

    bench, case, names = script.bench, script.case, script.names
    moving = {name: chain for name, chain in zip(names, bench.chains, strict=True) if chain.mass.size}
    yielding = {name: opensees.storeys_of(bench, building) for building, name in enumerate(names)}
    contacts: dict[str, tuple[Any, ...]] = {}
    computed: dict[str, dict[str, Any]] = {}

    def ends(place: Any) -> list[tuple[str, int] | None]:
        """Building and floor on both sides of a link or a contact; None is a rigid building."""
        sides = zip(names[place.interface :], (place.left_floor, place.right_floor), strict=False)
        return [(name, int(floor)) if name in moving else None for name, floor in sides]

    for k, point in bench.contact_points.items():
        interface = " | ".join(names[point.interface : point.interface + 2])
        label = f"{interface}, floors {point.left_floor:g} and {point.right_floor:g}"
        label += f" at {point.across:g} m" if isfinite(point.across) else ""
        if k in script.computed:
            computed[label] = {"ends": script.ends(k), "gap": _plain(case.gaps[k])} | script.computed[k]._asdict()
            continue
        material = opensees.impact_material(bench.chains, point, (case.gaps[k], case.laws[k], case.rules[k]))
        contacts[label] = (*ends(point), tuple(map(_plain, material)))
    return {
        "buildings": {
            name: list(zip(chain.mass.tolist(), opensees.beside(chain, yielding[name]), strict=True))
            for name, chain in moving.items()
        },
        "rotations": {
            name: list(range(chain.floors + 1, chain.mass.size + 1)) for name, chain in moving.items() if chain.twists
        },
        "yielding": {name: yielding[name] for name in moving},
        "springs": {name: opensees.joins(chain.coupling) for name, chain in moving.items()},
        "dashpots": {name: opensees.joins(chain.damping) for name, chain in moving.items()},
        "links": [
            (*ends(link), opensees.link_material(link), opensees.link_dashpot(link)) for link in bench.study.links
        ],
        "contacts": contacts,
        "computed": computed,
        "peaks": _peaks(script),
    }


def _peaks(script: Script) -> dict[str, tuple[float, float]]:
    """Peak relative displacement [m] and contact force [N] by interface; raises SceneError where a run has none."""
    from pounding_risk.lab.accuracy_findings import FORCE, REACH

    answers = script.bench.event(RTOL).values[0][:, [REACH, FORCE]]
    if not np.isfinite(answers).all():
        study = script.bench.study
        why = "its run has no peaks to set beside those of a script, as a storey collapses or the run fails"
        raise SceneError(study.source, [f"OpenSees cannot say this scene: {why}; `pounding-risk simulate` says which"])
    interfaces = [f"{left} | {right}" for left, right in pairwise(script.names)]
    return {name: (reach, force) for name, (reach, force) in zip(interfaces, answers.tolist(), strict=True)}


def _plain(parameter: Any) -> Any:
    return parameter if isinstance(parameter, str) else float(np.asarray(parameter))


def _notes(script: Script) -> Iterator[str]:
    """What of a scene the script has not, or does in another way."""
    from pounding_risk.lab.accuracy_opensees import MATERIALS, divides_by_rest, name_of

    bench = script.bench
    yield f"other cases of the grid: it is {bench.labels[0]}"
    if numbers := [key for axis in bench.study.axes for key in axis.keys]:
        yield f"values along axes and of uncertain numbers: {listed(numbers)} as written in the tables of the scene"
    if len(bench.motions) > 1:
        yield f"{counted(len(bench.motions) - 1, 'further motion')} of the scene"
    laws = [script.case.laws[k] for k in script.computed]
    laws = sorted({name_of(law) for law in laws if type(law).__name__ not in MATERIALS})
    reasons = [f"material for {law}" for law in laws]
    at_rest = any(divides_by_rest(script.case.laws[k], script.case.gaps[k]) for k in script.computed)
    reasons += ["least speed of a touch in Hertzdamp, which floors in touch at rest need"] if at_rest else []
    computed = [(k, bench.contact_points[k]) for k in script.computed]
    # A contact point part-way up a column has shares of two floors.
    on_floors = [k for k, point in computed if not isfinite(point.across)]
    is_between = any(share not in (-1.0, 1.0) for k in on_floors for *_, share in script.ends(k))
    reasons += ["element for a floor against a column"] if is_between else []
    reasons += ["element in one direction for an end of a face that rotates"] if len(on_floors) < len(computed) else []
    if reasons:
        yield (
            f"OpenSees has no {' and no '.join(reasons)}: the script computes these forces itself by the formula of "
            "pounding-risk, at each step from the state that the last accelerations give for its end"
        )
