"""The contact laws that a scene's grid runs, with their stiffness and its effects."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pounding_risk.errors import SceneError
from pounding_risk.models.contact.relation import least_of, out_of_reach
from pounding_risk.models.effects import with_effects
from pounding_risk.scene.scene import Study
from pounding_risk.solver.pair.isolated import equal_stiffness


def laws_of(study: Study) -> tuple[Any, ...]:
    """The grid's contact laws with their stiffness; where a k is no β, the one that equal terms lead to."""
    return tuple(law_of(study, name) for name in study.grid.contact_models)


def law_of(study: Study, name: str) -> Any:
    """One contact law of the scene with its effects; its stiffness by equal terms where the unit differs.

    Raises as `check_reach`.
    """
    check_reach(study, (name,))
    return with_effects(_calibrated(study, name), study.effects)


def _calibrated(study: Study, name: str) -> Any:
    terms = study.equal_terms
    if not study.needs_equal_terms(name) or terms is None:
        return study.law(name)
    stiffness = equal_stiffness(
        lambda value: study.law(name, value),
        study.law(study.stiff_name),
        terms.speed,
        study.striking_mass,
        study.restitution,
        terms.same,
    )
    return study.law(name, stiffness)


def beyond_reach(study: Study, names: Iterable[str]) -> str:
    """A sentence for the first law that cannot return the scene's e under its relation, or the least of its e(v)."""
    least = least_of(study.restitution)
    told = (out_of_reach(study.law_class(name), least, study.design_penetration) for name in names)
    return next(filter(None, told), "")


def check_reach(study: Study, names: Iterable[str]) -> None:
    """Raise SceneError for a law that cannot return the scene's e: see `beyond_reach`."""
    if sentence := beyond_reach(study, names):
        raise SceneError(study.source, [f"interface.restitution: {sentence}"])
