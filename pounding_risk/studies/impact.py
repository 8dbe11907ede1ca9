"""Impact of two free masses under one contact law."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any, get_type_hints

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import needs_floors
from pounding_risk.models.contact.relation import AS_PUBLISHED, faults, is_ratio, misfit, related, written_ratio
from pounding_risk.models.effects import bare
from pounding_risk.models.restitution import NAMED, Restitution, constant
from pounding_risk.solver.pair.isolated import Impact, collide
from pounding_risk.units import MASS, RESTITUTION, RTOL, SPEED, YIELD_FORCE, Quantity, QuantityError, si


def impact(
    law: Any,
    speed: float | str,
    mass: float | str,
    other_mass: float | str = inf,
    *,
    restitution: float | str | Restitution | Mapping[str, Any] = 1.0,
    relation: str = AS_PUBLISHED,
    yield_force: float | str = inf,
    rtol: float = 1e-12,
) -> Impact:
    """Impact of two free masses under one contact law, without springs, dampers or ground motion.

    The contact obeys m δ̈ = −F(δ, δ̇) with m = m1 m2 / (m1 + m2), from δ = 0 and δ̇ = ``speed`` to the parting.

    Parameters
    ----------
    law : contact law
        A law with its parameters, such as ``Jankowski(2.75e9)``, or a model such as ``DistributedMass(10.0, 20.0)``,
        whose left floor strikes.
    speed : float or str
        Relative speed at the touch, a number in m/s or a text with a unit.
    mass : float or str
        Mass of the striking body, a number in kg or a text with a unit.
    other_mass : float or str
        Mass of the struck body [kg]; infinite, a fixed wall, by default.
    restitution : float, str, Restitution or mapping
        A number in (0, 1], a relation such as ``CONCRETE``, or as in a scene: "concrete", "xi 0.35 of jankowski",
        ``{"value": 0.65, "relation": "exact"}``.
    relation : str
        "published" takes the damping that the law's authors give for e; "exact" takes the one with which the law, below
        its cap, returns e.
    yield_force : float or str
        Largest force of laws with a cap, a number in N or a text with a unit.
    rtol : float
        Relative tolerance of the integration.

    Returns
    -------
    Impact
        Histories of time [s], penetration [m] and force [N], and the restitution, peaks, impulse and duration.

    Raises
    ------
    PoundingError
        If a speed or mass is not above zero, or the law cannot take the relation, or this e under it.
    """
    speed, mass = si(speed, SPEED, "impact: speed"), si(mass, MASS, "impact: mass")
    other_mass = si(other_mass, MASS._replace(open_high=False), "impact: other_mass")
    yield_force = si(yield_force, YIELD_FORCE, "impact: yield_force")
    rtol = si(rtol, RTOL._replace(low=0.0, open_low=True), "impact: rtol")
    law, rule = _damped(_in_si(law), restitution, relation)
    return collide(law, rule, speed, (mass, other_mass, yield_force, rtol))


def _in_si(law: Any) -> Any:
    """The law with its parameters as numbers; raises PoundingError for what is no law or no value of a parameter."""
    if not hasattr(law, "_fields"):
        raise PoundingError(
            f"impact: {law!r} is not a contact law; give one with its parameters, such as Jankowski(2.75e9)"
        )
    hints, parameters = get_type_hints(type(law), include_extras=True), {}
    for name in law._fields:
        for quantity in getattr(hints.get(name), "__metadata__", ()):
            if isinstance(quantity, Quantity):
                # A floor of no length is a wall.
                bounds = quantity._replace(open_low=False) if needs_floors(law) else quantity
                parameters[name] = si(getattr(law, name), bounds, f"impact: {type(law).__name__}: {name}")
    return law._replace(**parameters) if parameters else law


def _damped(law: Any, restitution: Any, relation: str) -> tuple[Any, Restitution]:
    """The law under a relation, and e(v)."""
    options = restitution if isinstance(restitution, Mapping) else {"value": restitution}
    options = {"relation": relation, **options}
    refusals = [f"{key}: {sentence}" for key, sentence in faults(options)] or [
        misfit([type(bare(law))], options["relation"])
    ]
    if refusals[0]:
        raise PoundingError(f"impact: restitution, {'; '.join(refusals)}")
    law, restitution = _related(law, options["relation"]), options["value"]
    return law, restitution if isinstance(restitution, Restitution) else restitution_of(restitution)


def _related(law: Any, relation: str) -> Any:
    """The law under a relation, within its effects."""
    if hasattr(law, "law"):
        return law._replace(law=_related(law.law, relation))
    return related(type(law), relation)(*law)


def restitution_of(words: str | float) -> Restitution:
    """A restitution from a number, the name of a relation or a damping ratio such as "xi 0.35 of jankowski".

    Raises PoundingError with what is allowed.
    """
    if isinstance(words, str) and words in NAMED:
        return NAMED[words]
    if is_ratio(words):
        return constant(written_ratio(str(words))[0])
    try:
        return constant(si(words, RESTITUTION))
    except QuantityError:
        names = ", ".join(NAMED)
        raise PoundingError(
            f"restitution {words!r}: it is neither a number in (0, 1] nor a known relation ({names}); "
            "write one of these"
        ) from None
