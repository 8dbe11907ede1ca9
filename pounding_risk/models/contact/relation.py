"""Restitution and damping of a law: the published relation or the exact one, and e from a damping ratio ξ.

Papers give ξ in the place of e; a law's inverse of the relation ξ(e) under which it was published stands beside it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import INSTANT_LAWS, is_instant
from pounding_risk.models.contact.laws import EXACT, LAWS, RESTITUTION_OF_RATIO
from pounding_risk.models.restitution import Restitution
from pounding_risk.units import Quantity, QuantityError, parse, shown

AS_PUBLISHED, AS_ASKED = RELATIONS = ("published", "exact")
EXAMPLE = '{value = 0.65, relation = "exact"}'
KEYS = ("value", "relation")
WRITTEN_RATIO = re.compile(r"(?:xi|ξ)\s*=?\s*(?P<ratio>\S+)(?:\s+of\s+(?P<law>\S+))?")
RATIO_EXAMPLE = '"xi 0.35 of jankowski"'

_FAMILY = {exact: law for law, exact in EXACT.items()}


def related(law: Any, relation: str) -> Any:
    """The class of ``law`` under a relation; an elastic law has no damping and stays as it is, and so does a jump by e.

    Raises PoundingError for a law with damping of which no exact relation is known.
    """
    if relation == AS_PUBLISHED or not law.needs_restitution or is_instant(law):
        return law
    if law not in EXACT:
        raise PoundingError(f"restitution: {_no_relation([name_of(law)])}")
    return EXACT[law]


def name_of(law: type) -> str:
    """The scene-file name of a law's class, or the class's own where it has none."""
    kind = _FAMILY.get(law, law)
    known = dict(INSTANT_LAWS) | LAWS.members  # a class that exists has been imported
    return next((name for name, law in known.items() if law is kind), kind.__name__)


def misfit(laws: Iterable[Any], relation: str) -> str:
    """A sentence where these laws cannot take the relation; "" where they can.

    Elastic laws may stand beside damped ones, but not alone; a damped law without an exact relation may not.
    """
    laws = list(laws)
    if relation == AS_PUBLISHED or not laws:
        return ""
    damped = [law for law in laws if law.needs_restitution]
    unknown = [name_of(law) for law in damped if law not in EXACT and not is_instant(law)]
    if unknown:
        return _no_relation(unknown)
    if damped:
        return ""
    names = [name_of(law) for law in laws]
    subject = f"{names[0]} uses" if len(names) == 1 else f"{', '.join(names)} use"
    return f"{subject} no restitution, so that no relation leads to a damping; remove relation, or choose {_able()}"


def out_of_reach(law: Any, e: float, design_penetration: float = 0.0) -> str:
    """A sentence where a class under its relation cannot return this e; "" where it can.

    Only a class with a method ``out_of_reach`` has a limit: the exact bilinear law.
    """
    limit = getattr(law, "out_of_reach", None)
    return limit(e, design_penetration) if limit else ""


def least_of(rule: Restitution) -> float:
    """The smallest e of a relation e(v): the published ones fall with the speed."""
    return float(rule.at(rule.fastest)) if rule.fastest < inf else rule.c0


def _no_relation(names: list[str]) -> str:
    return f'no exact relation is known for {", ".join(names)}; write relation = "published", or choose {_able()}'


def _able() -> str:
    known = [name_of(law) for law in EXACT]
    return f"{', '.join(known[:-1])} or {known[-1]}"


def faults(table: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Faults of a table of value and relation other than those of the value: (key, sentence) of each."""
    sentences = [
        (key, f"unknown key{nearest(key, KEYS)}; a restitution takes value and relation")
        for key in table
        if key not in KEYS
    ]
    if "value" not in table:
        sentences.append(("value", f"missing; write restitution = {EXAMPLE}"))
    fault = relation_fault(table.get("relation", AS_PUBLISHED))
    return [*sentences, ("relation", fault)] if fault else sentences


def relation_fault(value: Any) -> str:
    """A sentence for what is not the name of a relation; "" for one that is."""
    if value in RELATIONS:
        return ""
    hint = nearest(value, RELATIONS)
    return f'{shown(value)} is not a relation of restitution and damping{hint}; it may be "published" or "exact"'


def restitution_of_ratio(ratio: float, law: str) -> float:
    """e in (0, 1] at which a law has the damping ratio ξ >= 0, which is below 1 for the Kelvin-Voigt laws.

    Raises QuantityError for a law without a ratio, and a ratio out of range.
    """
    if law not in RESTITUTION_OF_RATIO:
        known = ", ".join(RESTITUTION_OF_RATIO)
        raise QuantityError(f"{law} has no damping ratio ξ; it may be of {known}, or write e itself")
    function, largest = RESTITUTION_OF_RATIO[law]
    words = f"damping ratio ξ of {law}"
    limits = Quantity("1", 0.0, largest, words, open_high=largest == 1.0, example=RATIO_EXAMPLE)
    restitution = function(parse(ratio, limits))
    if not restitution > 0.0:
        raise QuantityError(f"ξ = {ratio:g} of {law} leaves no rebound at all; write a smaller ratio")
    return restitution


def is_ratio(text: object) -> bool:
    """Whether a text is meant as a damping ratio: it begins with xi or ξ."""
    return isinstance(text, str) and re.match(r"\s*(xi|ξ)\b", text) is not None


def written_ratio(text: str) -> tuple[float, str]:
    """The e of a text such as "xi 0.35 of jankowski", and words that state its origin.

    Raises QuantityError for text of another form, and as `restitution_of_ratio`.
    """
    match = WRITTEN_RATIO.fullmatch(text.strip())
    if match is None or match["law"] is None:
        raise QuantityError(f"{shown(text)} does not say the damping ratio of which law; write such as {RATIO_EXAMPLE}")
    ratio = parse(match["ratio"], Quantity("1", 0.0, float("inf"), "damping ratio ξ", example=RATIO_EXAMPLE))
    restitution = restitution_of_ratio(ratio, match["law"])
    return restitution, f"{restitution:.6g}, from ξ = {ratio:g} of {match['law']}"
