"""Which kernels a scan of a scene would compile first, told without compiling any."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._jit.compile import INTERPRETED, ForgivingCache, is_foreign, lowered
from pounding_risk.ensemble.row_grid import model_of
from pounding_risk.models.effects import wave_of, with_effects
from pounding_risk.scene.scene import Study
from pounding_risk.solver.pair.api import at_rest, oscillators
from pounding_risk.solver.pair.contact import integrate_contact
from pounding_risk.solver.pair.free import fill_free_response
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.isolated import meeting
from pounding_risk.solver.pair.outputs import COLUMNS
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row import laws as rows_laws
from pounding_risk.solver.row import run as rows_march
from pounding_risk.solver.workspace import make_workspace

# Compiling on one core of the machine that this was written on [s].
LAW_OF_A_PAIR, MOTION_OF_A_PAIR = 12.0, 5.0
SOLVER_OF_ROWS, MOTION_OF_ROWS, LAW_OF_A_ROW = 45.0, 15.0, 1.0
STILL = np.zeros(2), 0.01  # a ground motion that only has the types of one


class Kernels(NamedTuple):
    """What of a scene is compiled already."""

    motion: bool  # without contact
    solver: bool  # with contact, what all contact models share; a pair's share nothing
    laws: tuple[bool, ...]  # by contact model of the grid
    at_each_start: bool  # no cache keeps what the contact models need: a row's
    interpreted: bool = False  # compilation is switched off

    @property
    def missing(self) -> int:
        """Contact models that are to be compiled."""
        return self.laws.count(False)

    @property
    def seconds(self) -> float:
        """About the time that compiling takes."""
        if self.at_each_start:
            shared = SOLVER_OF_ROWS * (not self.solver) + MOTION_OF_ROWS * (not self.motion)
            return shared + LAW_OF_A_ROW * self.missing
        return MOTION_OF_A_PAIR * (not self.motion) + LAW_OF_A_PAIR * self.missing

    @property
    def whole(self) -> bool:
        """True where nothing is to be compiled."""
        return self.motion and self.solver and not self.missing


def kernels_of(study: Study) -> Kernels:
    """What is compiled for this scene, in this process or in the cache; raises as `Study.law`."""
    if INTERPRETED:
        return Kernels(True, True, (True,) * len(study.grid.contact_models), False, interpreted=True)
    return _of_row(study) if study.is_row else _of_pair(study)


def _of_pair(study: Study) -> Kernels:
    pair = oscillators(*study.pair)
    free = at_rest(pair, *STILL, wave_of(study.effects))
    cases = np.zeros(1), np.zeros(1), study.restitution
    room = make_workspace(study.rtol), np.zeros((1, 1, COLUMNS)), np.zeros((1, 1), np.int8)

    def known(name: str) -> bool:
        law = lowered(_like(study, name))
        return is_compiled(solve_grid, (pair, free, law, cases, study.rtol, True, *room)) and _calibrates(study, name)

    return Kernels(
        is_compiled(fill_free_response, (pair, free, room[0])),
        True,
        tuple(map(known, study.grid.contact_models)),
        False,
    )


def _of_row(study: Study) -> Kernels:
    *call, terms, states = rows.unmoved(model_of(study).row(STILL[1]), STILL[0])
    solver = is_compiled(rows_march.march, (*call, terms, study.rtol, states))
    places = [study.at(place) for place in range(len(study.neighbours))]

    def known(name: str) -> bool:
        # What a process has compiled of a law for its rows is kept by that process alone.
        entered = all(rows_laws.kind_of(lowered(_like(here, name))) in rows_laws._VERBS for here in places)
        return entered and all(_calibrates(here, name) for here in places)

    laws = tuple(map(known, study.grid.contact_models))
    return Kernels(is_compiled(rows_march.march_free, (*call, terms, states)), solver, laws, at_each_start=True)


def _like(study: Study, name: str) -> Any:
    """A contact model as the scene has it, but for the number of its stiffness: that may take a run to find."""
    return with_effects(study.law(name, 1.0 if study.needs_equal_terms(name) else None), study.effects)


def _calibrates(study: Study, name: str) -> bool:
    """True where the stiffness by equal terms, if there are any, is found without compiling."""
    if not study.needs_equal_terms(name) or study.equal_terms is None:
        return True
    laws = study.law(study.stiff_name), study.law(name, 1.0)
    blow = 1.0, 1.0, 1.0, 1e-12
    # A model without a force has no stiffness to find, so that each of these meets in a contact of finite force.
    return all(is_compiled(integrate_contact, meeting(law, study.restitution, 1.0, blow)) for law in laws)


def is_compiled(kernel: Any, arguments: Iterable[Any]) -> bool:
    """True where a call of ``kernel`` with these very arguments would compile nothing.

    False of a kernel that is interpreted: calls of it are never fast.
    """
    if not hasattr(kernel, "typeof_pyval"):
        return False
    kinds = tuple(map(kernel.typeof_pyval, arguments))
    return kinds in kernel.overloads or _is_kept(kernel, kinds)


def _is_kept(kernel: Any, kinds: tuple[Any, ...]) -> bool:
    """True where the cache has code for these types that can be read; numba itself asks by compiling."""
    cache = kernel._cache
    if not isinstance(cache, ForgivingCache) or any(map(is_foreign, kinds)):
        return False
    try:
        key = cache._index_key(kinds, kernel.targetctx.codegen())
        return cache._cache_file.load(key) is not None
    except Exception:  # unpickling a damaged file may raise anything: such code is compiled anew
        return False
