"""Which kernels of a scene are compiled already, found out without compiling any."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._jit.compile import lowered
from pounding_risk._jit.lent import lent
from pounding_risk._jit.sources import INTERPRETED
from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.pair_job import is_worth_kernels
from pounding_risk.ensemble.row_grid import model_of
from pounding_risk.models.effects import with_effects
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.counters import make_log
from pounding_risk.solver.pair.api import at_rest, oscillators
from pounding_risk.solver.pair.contact import integrate_contact
from pounding_risk.solver.pair.free import fill_free_response
from pounding_risk.solver.pair.grid import march_grid
from pounding_risk.solver.pair.isolated import meeting
from pounding_risk.solver.pair.laws import unnamed, verb_kernel
from pounding_risk.solver.pair.outputs import COLUMNS
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row import run as rows_march
from pounding_risk.solver.row.free_motion import march_free
from pounding_risk.solver.row.impulsive.api import jumps, unmoved_jumps
from pounding_risk.solver.row.impulsive.run import march_jumps
from pounding_risk.solver.workspace import make_workspace

STILL = np.zeros(2), 0.01  # a ground motion of zeros: only its types matter


class Kernels(NamedTuple):
    """The kernels of a scene: True for those that are compiled."""

    motion: bool  # the motion without contact
    solver: bool  # what all contact models share
    laws: tuple[bool, ...]  # by contact model of the grid
    interpreted: bool = False  # compilation is switched off

    @property
    def missing(self) -> int:
        """Number of contact models that are to be compiled."""
        return self.laws.count(False)

    @property
    def whole(self) -> bool:
        """True where nothing is to be compiled."""
        return self.motion and self.solver and not self.missing


def kernels_of(study: Scene, cases: int = 0, motions: Sequence[Motion] = ()) -> Kernels:
    """What is compiled for a scene, in this process or in the cache; raises as `Scene.law`.

    ``cases`` of its grid and its ``motions`` decide whether its laws get kernels of their own.
    """
    if INTERPRETED:
        return Kernels(True, True, (True,) * len(study.grid.contact_models), interpreted=True)
    if job_kind(study).solver == "row":
        return _of_row(study)
    return _of_pair(study, is_worth_kernels(study, cases, motions))


def _of_pair(study: Scene, own_kernels: bool) -> Kernels:
    pair = oscillators(*study.pair)
    free = at_rest(pair, *STILL, study.supports, _still_grounds(study))
    cases = np.zeros(1), np.zeros(1), study.restitution
    log = make_log(0, 0, np.zeros(0))
    room = (log, log, log), make_workspace(study.rtol), np.zeros((1, 1, COLUMNS)), np.zeros((1, 1), np.int8)

    def has_grid(law: Any) -> bool:
        return is_compiled(march_grid, (pair, free, law, cases, study.rtol, True, *room))

    def known(name: str) -> bool:
        law = lowered(_like(study, name))
        by_address = has_grid(unnamed(law)) and is_compiled(*verb_kernel(law))
        return (has_grid(law) if own_kernels else by_address) and _calibrates(study, name)

    return Kernels(
        is_compiled(fill_free_response, (pair, free, room[1])),
        True,
        tuple(map(known, study.grid.contact_models)),
    )


def _of_row(study: Scene) -> Kernels:
    model, own = model_of(study), _still_grounds(study)
    layout = model.row(STILL[1], model.has_many(own))
    *bundles, states = rows.unmoved(layout, model.under(STILL[0], own))
    row, run, motion, work = map(lent, bundles)
    solver = is_compiled(rows_march.march, (row, run, motion, study.rtol, states))
    places = [study.at(place) for place in range(len(study.interfaces))]

    def known(name: str) -> bool:
        if jumps([known_law(one) for one in study.models_of(name)]):
            return is_compiled(march_jumps, unmoved_jumps(layout, study.rtol))
        verbs = (verb_kernel(lowered(_like(here, name))) for here in places)
        return all(is_compiled(*kernel) for kernel in verbs) and all(_calibrates(here, name) for here in places)

    names = study.models_of(*study.grid.contact_models)
    solver = solver or jumps([known_law(name) for name in names])  # which have a solver of their own
    laws = tuple(map(known, study.grid.contact_models))
    return Kernels(is_compiled(march_free, (row, run, motion, work, states)), solver, laws)


def _still_grounds(study: Scene) -> tuple[np.ndarray | None, ...]:
    """Still ground under each building that has a record of its own."""
    return tuple(STILL[0] if support.records else None for support in study.supports)


def _like(study: Scene, name: str) -> Any:
    """A contact model of the scene; its stiffness is 1 where finding it takes a run."""
    return with_effects(study.law(name, 1.0 if study.needs_equal_terms(name) else None), study.effects)


def _calibrates(study: Scene, name: str) -> bool:
    """True where the stiffness by equal terms, if the scene has any, is found without compiling."""
    if not study.needs_equal_terms(name) or study.equal_terms is None:
        return True
    laws = study.law(study.stiff_name), study.law(name, 1.0)
    blow = 1.0, 1.0, 1.0, 1e-12
    # A model without a force has no stiffness to find, so that each of these meets in a contact of finite force.
    contact = is_compiled(integrate_contact, meeting(unnamed(laws[0]), study.restitution, 1.0, blow))
    return contact and all(is_compiled(*verb_kernel(lowered(law))) for law in laws)


def is_compiled(kernel: Any, arguments: Iterable[Any]) -> bool:
    """True where calling ``kernel`` with these arguments would compile nothing; False of an interpreted kernel."""
    if not hasattr(kernel, "typeof_pyval"):
        return False
    kinds = tuple(map(kernel.typeof_pyval, arguments))
    return kinds in kernel.overloads or _is_kept(kernel, kinds)


def _is_kept(kernel: Any, kinds: tuple[Any, ...]) -> bool:
    """True where the cache has readable code for these types; numba itself would compile to find out."""
    from pounding_risk._jit.lowering.cache import ForgivingCache, is_foreign  # with numba, which is there by now

    cache = kernel._cache
    if not isinstance(cache, ForgivingCache) or any(map(is_foreign, kinds)):
        return False
    try:
        key = cache._index_key(kinds, kernel.targetctx.codegen())
        return cache._cache_file.load(key) is not None
    except Exception:  # unpickling a damaged file may raise anything: such code is compiled anew
        return False
