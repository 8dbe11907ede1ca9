"""A scene as a commented OpenSeesPy script that runs by itself, with the peaks of this package to hold it against."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from pprint import pformat
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk._common.version import __version__
from pounding_risk.errors import SceneError
from pounding_risk.motions.levels import at_pga
from pounding_risk.reports.exports._written import Asked, Written, write_file

if TYPE_CHECKING:
    from pounding_risk.scene.scene import Scene
    from pounding_risk.studies.accuracy_bench import Bench

WORDS = "a scene as an OpenSeesPy script"
ENDINGS = (".py",)
SOURCE = "scene"
TAKES = ("gap", "pga")
STEPS_A_SAMPLE = 10  # of the script, unless asked otherwise
RTOL = 1e-10  # of the peaks that the script shows beside its own

TEMPLATE = '''"""{title}, in OpenSeesPy.

{case}.

Written by pounding-risk {version}.
Units are N, kg, m and s; displacements are relative to the ground. Run it with `python {name} [STEP]`,
where STEP is the time step in s ({step:g} by default); it needs openseespy. Its error falls with the step: compare
two. What the scene has and this script has not:
{told}
"""

import sys

import openseespy.opensees as ops

STEP = float(sys.argv[1]) if len(sys.argv) > 1 else {step!r}

# Of each building, from the ground up: mass of a floor [kg], stiffness of the storey below it [N/m], and dashpots to
# the floor below and to the ground [N s/m] that make up the building's damping matrix.
BUILDINGS = {buildings}

# Of each contact: (building, floor) on its left and right, and the impact material with its numbers; OpenSees measures
# lengths in contact as negative. A gap of zero is 1e-12 m, since the materials refuse it. None is the ground: a rigid
# building moves with it.
CONTACTS = {contacts}

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

# A mass is a node; storeys are elements without length.
node_of = {{None: GROUND}}
tag = GROUND
for building, storeys in BUILDINGS.items():
    below = GROUND
    for floor, (mass, stiffness, dashpot, to_ground) in enumerate(storeys, start=1):
        tag += 1
        node = tag
        node_of[building, floor] = node
        ops.node(node, 0.0)
        ops.mass(node, mass)
        for spring, damper, other in ((stiffness, dashpot, below), (0.0, to_ground, GROUND)):
            tag += 1
            ops.uniaxialMaterial("Elastic", tag, spring, damper)
            ops.element("zeroLength", tag, other, node, "-mat", tag, "-dir", 1, "-doRayleigh", 0)
        below = node

elements = []
for left, right, (material, *numbers) in CONTACTS.values():
    tag += 1
    ops.uniaxialMaterial(material, tag, *numbers)
    ops.element("zeroLength", tag, node_of[left], node_of[right], "-mat", tag, "-dir", 1)
    elements.append(tag)

ops.timeSeries("Path", 1, "-dt", SAMPLING, "-values", *MOTION)
ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
# At rest the first sample acts already, where Newmark's rule would begin without it.
for node in set(node_of.values()) - {{GROUND}}:
    ops.setNodeAccel(node, 1, -MOTION[0], "-commit")

# Newmark's average acceleration. The test is tight, as masses move less than 1e-6 m in a short step.
ops.constraints("Plain")
ops.numberer("RCM")
ops.system("ProfileSPD")
ops.test("NormDispIncr", 1e-12, 100)
ops.algorithm("ModifiedNewton")
ops.integrator("Newmark", 0.5, 0.25)
ops.analysis("Transient")

reach = [0.0] * len(elements)
force = [0.0] * len(elements)
for step in range(round((len(MOTION) - 1) * SAMPLING / STEP)):
    if ops.analyze(1, STEP):
        sys.exit(f"no convergence at {{ops.getTime():.4g}} s; try a shorter step")
    for number, element in enumerate(elements):
        reach[number] = max(reach[number], abs(ops.eleResponse(element, "deformation")[0]))
        force[number] = max(force[number], -ops.eleResponse(element, "material", 1, "stress")[0])

print(f"{{'contact':32}} {{'peak relative displacement [m]':>32}} {{'peak contact force [N]':>26}}")
for name, moved, pressed in zip(CONTACTS, reach, force):
    print(f"{{name:32}} {{moved:32.9g}} {{pressed:26.9g}}")
print("pounding-risk")
for name, (moved, pressed) in PEAKS.items():
    print(f"{{name:32}} {{moved:32.9g}} {{pressed:26.9g}}")
'''


class Lines(NamedTuple):
    """What of a scene stands in the script."""

    buildings: dict[str, list[tuple[float, ...]]]
    contacts: dict[str, tuple[Any, ...]]
    peaks: dict[str, tuple[float, float]]


def write(study: Scene, target: Path, asked: Asked) -> Written:
    """Write the case of the scene's own gap under its first motion; raises SceneError for what OpenSees cannot say."""
    from pounding_risk.studies.accuracy import bench_of
    from pounding_risk.studies.accuracy_opensees import unsaid_case

    grid = study.grid
    own = grid._replace(
        gaps=(study.gap if asked.gap is None else asked.gap,),
        amplitudes=grid.amplitudes[:1] if asked.pga is None else (at_pga(asked.pga),),
        yield_forces=(study.yield_force,),
        contact_models=(study.contact_model,),
    )
    bench = bench_of(study.updated(grid=own), 1)
    if why := unsaid_case(bench):
        raise SceneError(study.source, [f"OpenSees cannot say this scene: {why}"])
    told = tuple(_told(bench))
    motion = next(iter(bench.motions))
    text = TEMPLATE.format(
        title=study.name or "A scene",
        case=bench.labels[0],
        version=__version__,
        name=target.name,
        step=motion.dt / STEPS_A_SAMPLE,
        told="\n".join(f"- {sentence}" for sentence in told),
        sampling=motion.dt,
        motion=_listed(motion.acceleration.tolist()),
        **{name: pformat(part, sort_dicts=False, width=118) for name, part in _lines(study, bench)._asdict().items()},
    )
    return Written((write_file(target, text),), told)


def _listed(values: list[float]) -> str:
    """Numbers in lines of a script, in full."""
    rows = (values[start : start + 4] for start in range(0, len(values), 4))
    body = "".join(f"    {', '.join(map(repr, row))},\n" for row in rows)
    return f"[\n{body}]"


def _lines(study: Scene, bench: Bench) -> Lines:
    """The numbers of the first case."""
    from pounding_risk.studies.accuracy_findings import FORCE, REACH
    from pounding_risk.studies.accuracy_opensees import dashpots, impact_material

    names = [building.name for building in study.buildings]
    buildings: dict[str, list[tuple[float, ...]]] = {}
    for name, chain in zip(names, bench.chains, strict=True):
        if chain.mass.size:
            columns = (chain.mass, chain.spring, *dashpots(chain))
            buildings[name] = [tuple(map(float, row)) for row in zip(*columns, strict=True)]
    case = next(bench.point_cases())
    contacts: dict[str, tuple[Any, ...]] = {}
    for k, point in enumerate(bench.points):
        sides = ((point.interface, point.left_floor), (point.interface + 1, point.right_floor))
        left, right = (
            (names[building], int(floor)) if bench.chains[building].mass.size else None for building, floor in sides
        )
        label = f"{names[point.interface]} | {names[point.interface + 1]}, floors {_floors(point)}"
        contact = case.gaps[k], case.laws[k], case.rules[k]
        material = tuple(_plain(part) for part in impact_material(bench.chains, point, contact))
        contacts[label] = (left, right, material)
    found = bench.event(RTOL).values[0]
    interfaces = [f"{left} | {right}" for left, right in pairwise(names)]
    peaks = {name: (float(row[REACH]), float(row[FORCE])) for name, row in zip(interfaces, found, strict=True)}
    return Lines(buildings, contacts, peaks)


def _floors(point: Any) -> str:
    return f"{point.left_floor:g} and {point.right_floor:g}"


def _plain(part: Any) -> Any:
    return part if isinstance(part, str) else float(np.asarray(part))


def _told(bench: Bench) -> Iterator[str]:
    """What of a scene the script has not."""
    yield f"other cases of the grid: it is {bench.labels[0]}"
    if len(bench.motions) > 1:
        yield f"{counted(len(bench.motions) - 1, 'further motion')} of the scene"
