"""The pages of contact models, effects and restitution, from the classes' own docstrings."""

from __future__ import annotations

from inspect import cleandoc
from typing import Any, get_type_hints

from generation.markdown import docstring, plain, table
from pounding_risk.models.contact import damping, impulsive, law
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.laws import EXACT, LAWS, SHIPPED, stiffness_quantity
from pounding_risk.models.effects import EFFECTS, PerInterface, acts_on_buildings, acts_on_ground, default_words
from pounding_risk.models.restitution import NAMED
from pounding_risk.scene.tables import option_example
from pounding_risk.units import Quantity, bounds

LAWS_HEAD = """# Contact models

Each is a class of a module in `pounding_risk/models/contact/laws/` or `impulsive/`; this page is made of their
docstrings.
[Contact](../theory/contact.md) has the main formulas side by side. `pounding-risk models` prints a list in a terminal,
a user's own laws too.

"""


def laws_page() -> str:
    """Every contact model: formula, parameters, source."""
    laws = {name: LAWS[name] for name in SHIPPED}
    heads = ("contact model", "stiffness in", "restitution", "yields at F\\_E")
    rows = [(f"[`{name}`](#{_anchor(name)})", *_facts(law)) for name, law in (laws | INSTANT_LAWS).items()]
    text = f"{LAWS_HEAD}{table(heads, rows)}\n## Laws of force and penetration\n\n{_symbols()}\n"
    text += "".join(_model(name, law) for name, law in laws.items())
    text += f"## Models whose velocities jump\n\n{_after_first(impulsive)}\n"
    text += "".join(_model(name, law) for name, law in INSTANT_LAWS.items())
    return f"{text}## Exact damping\n\n{docstring(damping)}"


def _anchor(name: str) -> str:
    return name.replace("_", "-")


def _facts(law: Any) -> tuple[str, str, str]:
    jumps = impulsive.is_instant(law)
    unit = "no stiffness" if jumps else plain(stiffness_quantity(law).unit)
    exact = "published, or exact" if law in EXACT else "exact" if jumps else "published"
    return unit, exact if law.needs_restitution else "takes no part", "yes" if law.capped else "no"


def _symbols() -> str:
    """The module's paragraph of symbols."""
    return docstring("Symbols" + (law.__doc__ or "").partition("Symbols")[2])


def _after_first(module: Any) -> str:
    return docstring((module.__doc__ or "").partition("\n\n")[2])


def _model(name: str, law: Any) -> str:
    text = f"({_anchor(name)})=\n### {plain(name)}\n\n{_without_parameters(law)}\n"
    rows = list(_parameters(law))
    if len(rows) > 1:
        text += table(("parameter", "what", "unit and range", "default"), rows) + "\n"
    exact = EXACT.get(law, law)
    if exact is not law:
        text += f'With `relation = "exact"`: {_without_parameters(exact)}\n'
    return f"{text}Source: {plain(law.reference)}.\n\n"


def _without_parameters(kind: Any) -> str:
    """A class's docstring; its section of parameters is the table's."""
    return docstring(cleandoc(kind.__doc__ or "").partition("\nParameters\n")[0])


def _parameters(law: Any) -> Any:
    hints = get_type_hints(law, include_extras=True)
    for name in law._fields:
        quantity = next((each for each in getattr(hints[name], "__metadata__", ()) if isinstance(each, Quantity)), None)
        if quantity is not None:
            default = law._field_defaults.get(name)
            usual = "" if default is None else f"{default:g}"
            yield f"`{name}`", plain(quantity.words), plain(_range(quantity)), usual


def _range(quantity: Quantity) -> str:
    return f"{quantity.unit}, {bounds(quantity)}".removeprefix("1, ")


EFFECTS_HEAD = """# Effects

Each is off unless a scene names it, and what is off is not in the machine code. Each is a class of a module in
`pounding_risk/models/effects/`; this page is made of their docstrings. Effects act in this order.

"""


def effects_page() -> str:
    """Every effect: what it does, its options, its source."""
    text = EFFECTS_HEAD
    for name, kind in EFFECTS.items():
        text += f"## {plain(name)}\n\n{_without_parameters(kind)}\n"
        rows = [(f"`{key}`", *_option(allowed, default_words(name, key))) for key, allowed in kind.options.items()]
        heads = ("option", "what", "unit and range", "example", "left out")
        text += f"{table(heads, rows)}\n" if rows else "It has no option.\n\n"
        needs = "".join(f" Needs `{each}`." for each in kind.needs)
        text += f"Acts on {_acts_on(name)}.{needs} "
        text += f"Source: {plain(kind.reference)}.\n\n"
    return text


def _acts_on(name: str) -> str:
    if acts_on_buildings(name):
        return "the buildings"
    return "the ground motion" if acts_on_ground(name) else "laws with a yield force"


def _option(allowed: Any, absent: str) -> tuple[str, str, str, str]:
    may = plain(absent)
    if isinstance(allowed, Quantity):
        words = (
            f"{allowed.words}; or a list, one for each interface"
            if isinstance(allowed, PerInterface)
            else allowed.words
        )
        return plain(words), plain(_range(allowed)), f"`{option_example(allowed)}`", may
    return " or ".join(f'`"{word}"`' for word in allowed), "", f"`{option_example(allowed)}`", may


def restitution_page() -> str:
    """Every named relation e(v), with its values."""
    speeds = (0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0)
    text = "# Named restitutions\n\ne at approach speeds in m/s. Past `fastest` e is held, and the run says so.\n\n"
    rows = [
        (f"`{name}`", *(f"{each:g}" for each in rule), *(f"{rule.at(speed):.3f}" for speed in speeds))
        for name, rule in NAMED.items()
    ]
    fields = [f"`{field}`" for field in next(iter(NAMED.values()))._fields]
    return text + table(("name", *fields, *(f"e({speed:g})" for speed in speeds)), rows)
