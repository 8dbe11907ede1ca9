"""The contact laws of the grid of a scene, with their stiffness and the effects of the scene."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from pounding_risk.errors import SceneError
from pounding_risk.models.contact.relation import least_of, out_of_reach
from pounding_risk.models.effects import with_effects
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.pair.isolated import equal_stiffness


def laws_of(study: Scene) -> tuple[Any, ...]:
    """The contact laws of the grid; where the unit of the stiffness differs, it follows from equal terms."""
    return tuple(law_of(study, name) for name in study.grid.contact_models)


def law_of(study: Scene, name: str) -> Any:
    """One contact law of the scene with its effects; raises as `check_reach`."""
    check_reach(study, (name,))
    terms, stiffness = study.equal_terms, None
    if study.needs_equal_terms(name) and terms is not None:
        own_law, mass = study.law(study.stiff_name), study.striking_mass
        stiffness = equal_stiffness(partial(study.law, name), own_law, terms.speed, mass, study.restitution, terms.same)
    return with_effects(study.law(name, stiffness), study.effects)


def beyond_reach(study: Scene, names: Iterable[str]) -> str:
    """A sentence for the first law that cannot reach the least coefficient of restitution of all interfaces.

    Of a relation e(v) its least value counts.
    """
    least = min(least_of(interface.restitution.rule) for interface in study.interfaces)
    sentences = (out_of_reach(study.law_class(name), least, study.design_penetration) for name in names)
    return next(filter(None, sentences), "")


def check_reach(study: Scene, names: Iterable[str]) -> None:
    """Raise SceneError for a law that cannot reach the scene's coefficient of restitution."""
    if sentence := beyond_reach(study, names):
        raise SceneError(study.source, [f"interface.restitution: {sentence}"])
