"""The command `models`: tables of every contact model, effect, typology and plug-in, made from their classes."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import Any

import typer

from pounding_risk.render.terminal import print_table
from pounding_risk.units import Quantity

ORDER = 100
# Where the registries are, or the functions that return them, by group of plug-ins.
REGISTRIES = {
    "laws": ("models.contact.laws", "LAWS"),
    "effects": ("models.effects", "EFFECTS"),
    "motions": ("motions.generated", "motion_kinds"),
    "steps": ("motions.processing", "known_steps"),
    "rules": ("assessment.separations.rules", "RULES"),
    "writers": ("reports.exports", "formats"),
}


def models(context: typer.Context) -> None:
    """Contact models, effects, typologies, plug-ins."""
    from pounding_risk.models.contact.impulsive import INSTANT_LAWS
    from pounding_risk.models.contact.laws import LAWS
    from pounding_risk.models.effects import EFFECTS
    from pounding_risk.models.structures.typologies import TYPOLOGIES

    heads = ("contact model", "stiffness", "restitution", "F_E", "what it is and where it is from")
    # The package's laws in the order of their module, then laws that a user has registered.
    print_table(heads, [_model(name, law) for name, law in {**dict(LAWS.items()), **INSTANT_LAWS}.items()], "lllll")
    print("\nRestitution: e is asked for; exact where a relation is known that returns it; – where none takes part.\n")
    print("Effects: after = stands what holds where the option is left out; an option without it is required.\n")
    effects = [_effect(name, effect) for name, effect in EFFECTS.items()]
    print_table(("effect", "options", "acts on", "where it is from"), effects, "llll")
    print()
    heads = ("typology", "period in s, h in m", "mode shape", "yields at, in g", "verified")
    typologies = [
        (kind.name, kind.period_words, kind.shape_words, kind.yield_words, "yes" if kind.code.verified else "NO",
         f"{kind.words}; {kind.code.reference}; {kind.code.source}")
        for kind in TYPOLOGIES.values()
    ]  # fmt: skip
    print_table((*heads, "where it is from"), typologies, "llllll")
    if plugins := list(_plugins(context)):
        print()
        print_table(("plug-in", "name", "from", "entry point", "state"), plugins, "lllll")


def _plugins(context: typer.Context) -> Iterator[tuple[str, ...]]:
    """Cells of the plug-ins of every kind; each is loaded."""
    from pounding_risk._common.plugins import GROUPS, installed, tell

    for group, plugins_by_name in installed().items():
        registry = _registry(group, context) if plugins_by_name else None
        for name, plugins in plugins_by_name.items():
            if problem := registry.problem(name) if registry else "":
                tell(problem)
            for plugin in plugins:
                yield GROUPS[group], name, plugin.origin, plugin.value, "not used" if problem else "loaded"


def _registry(group: str, context: typer.Context) -> Any:
    """The registry that has the plug-ins of a group."""
    if group == "commands":
        commands: Any = context.find_root().command
        return commands.commands.registry
    module, name = REGISTRIES[group]
    registry = getattr(import_module(f"pounding_risk.{module}"), name)
    return registry if hasattr(registry, "problem") else registry()


def _model(name: str, law: Any) -> tuple[str, ...]:
    """Cells of a contact model."""
    from pounding_risk.models.contact.impulsive import is_instant, needs_floors
    from pounding_risk.models.contact.laws import EXACT, stiffness_quantity

    stiffness = "floor lengths" if needs_floors(law) else "–" if is_instant(law) else stiffness_quantity(law).unit
    is_exact = law in EXACT or is_instant(law)
    restitution = "–" if not law.needs_restitution else "exact" if is_exact else "published"
    source = getattr(law, "reference", "")
    return name, stiffness, restitution, "yields" if law.capped else "–", f"{_first_line(law)} {source}".strip()


def _effect(name: str, effect: Any) -> tuple[str, ...]:
    """Cells of an effect."""
    from pounding_risk.models.effects import acts_on_buildings, acts_on_ground, default_words

    options = [
        (f"{key} [{allowed.unit}]" if isinstance(allowed, Quantity) else f"{key} ({' or '.join(allowed)})")
        + f" = {default_words(name, key)}" * (key in effect.optional)
        for key, allowed in effect.options.items()
    ]
    laws = " and ".join(["yielding", *effect.needs])
    acts_on = "the ground" if acts_on_ground(name) else "the buildings" if acts_on_buildings(name) else laws
    return name, ", ".join(options) or "–", acts_on, f"{_first_line(effect)} {effect.reference}"


def _first_line(kind: type) -> str:
    """The first line of a class's docstring; "" where a user's own class has none."""
    line = (kind.__doc__ or "").strip().partition("\n")[0]
    # A NamedTuple without a docstring has one that repeats its fields.
    return "" if line.startswith(f"{kind.__name__}(") else line
