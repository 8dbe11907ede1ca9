"""What `models` prints: every contact model, effect and typology there is, from the classes themselves."""

from __future__ import annotations

from typing import Any


def models() -> None:
    """Contact models, effects and typologies: what each takes."""
    from pounding_risk.cli.tables import print_table
    from pounding_risk.models.contact.impulsive import CONTACT_MODELS
    from pounding_risk.models.effects import EFFECTS
    from pounding_risk.models.structures.typologies import TYPOLOGIES

    heads = ("contact model", "stiffness", "restitution", "F_E", "what it is and where it is from")
    # The package's own first, in the order of their module; a user's own laws after them.
    print_table(heads, [_model(name, law) for name, law in CONTACT_MODELS.items()], "lllll")
    print("\nRestitution: e is asked for; exact where a relation is known that returns it; – where none takes part.\n")
    print("Effects: after = stands what holds where the option is left out; an option without it is required.\n")
    print_table(("effect", "options", "acts on", "where it is from"), list(map(_effect, EFFECTS.items())), "llll")
    print()
    kinds = ("typology", "period in s, h in m", "mode shape", "yields at, in g", "verified", "where it is from")
    print_table(kinds, list(map(_typology, TYPOLOGIES.values())), "llllll")


def _model(name: str, law: Any) -> tuple[str, ...]:
    from pounding_risk.models.contact.impulsive import is_instant, needs_floors
    from pounding_risk.models.contact.laws import EXACT, stiffness_quantity

    stiffness = "floor lengths" if needs_floors(law) else "–" if is_instant(law) else stiffness_quantity(law).unit
    exact = law in EXACT or is_instant(law)
    restitution = "–" if not law.needs_restitution else "exact" if exact else "published"
    about = _first_line(law)
    source = getattr(law, "reference", "")
    return name, stiffness, restitution, "yields" if law.capped else "–", f"{about} {source}".strip()


def _effect(entry: tuple[str, Any]) -> tuple[str, ...]:
    from pounding_risk.models.effects import acts_on_buildings, acts_on_ground, default_words
    from pounding_risk.units import Quantity

    name, kind = entry
    options = [
        (f"{key} [{allowed.unit}]" if isinstance(allowed, Quantity) else f"{key} ({' or '.join(allowed)})")
        + f" = {default_words(name, key)}" * (key in kind.optional)
        for key, allowed in kind.options.items()
    ]
    law = " and ".join(["yielding", *kind.needs])
    acts = "the ground" if acts_on_ground(name) else "the buildings" if acts_on_buildings(name) else law
    return name, ", ".join(options) or "–", acts, f"{_first_line(kind)} {kind.reference}"


def _typology(kind: Any) -> tuple[str, ...]:
    facts = kind.name, kind.period_words, kind.shape_words, kind.yield_words
    return *facts, "yes" if kind.code.verified else "NO", f"{kind.words}; {kind.code.reference}; {kind.code.source}"


def _first_line(kind: Any) -> str:
    """The first sentence of a class's docstring; "" where a user's own has none."""
    told = (kind.__doc__ or "").strip().partition("\n")[0]
    # A NamedTuple without a docstring is given one that repeats its fields.
    return "" if told.startswith(f"{kind.__name__}(") else told
