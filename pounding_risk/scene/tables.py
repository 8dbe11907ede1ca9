"""The tables [effects], [grid], [solver] and [scene]: their keys, and what effects and floors need of other tables."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, needs_floors
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.effects import (
    EFFECTS,
    PerInterface,
    default_example,
    defaults,
    read_option,
    refusal,
    written_option,
)
from pounding_risk.scene.buildings import RigidWall
from pounding_risk.scene.interfaces import LAW_NAMES, known_models
from pounding_risk.scene.keys import (
    Draft,
    Key,
    Number,
    Table,
    Unreadable,
    axis,
    by_address,
    facts,
    in_text,
    measured,
    options,
    text,
)
from pounding_risk.scene.toml import Fault, as_list
from pounding_risk.units import GAP, PGA, RTOL, YIELD_FORCE, Quantity, shown, written_example

_RANGE = "a list in ascending order, or {start, stop, num}; a dimension of the dataset"


def _zipped_addresses(value: Any, number: Number) -> tuple[tuple[str, ...], ...]:
    """Lists of addresses of axes that move together."""
    if not isinstance(value, list) or not all(isinstance(group, list) for group in value):
        raise Unreadable(f"{shown(value)} is not a list of lists of axes")
    return tuple(tuple(map(str, group)) for group in value)


NUMBERS = by_address(
    "Other numbers of the scene as axes, by the address that --set takes; in a file each stands in [grid] itself.",
    '{"building.frame.period" = {start = "0.2 s", stop = "2 s", num = 50}}',
    "no other number varies",
)
TOGETHER = Key(
    "Axes of such numbers that move together, along one dimension.",
    _zipped_addresses,
    '[["building.frame.mass", "building.frame.period"]]',
    "each is a dimension of its own",
    write=lambda groups: [list(group) for group in groups],
    schema={"type": "array", "items": {"type": "array", "items": {"type": "string"}}},
)


class Title(Table):
    """The table [scene] of a scene file: its name."""

    name: str = text("What reports and figures call the study.", "Frame beside masonry", "the file's name").defaults_to(
        ""
    )


class Grid(Table):
    """The values of each dimension of a scan."""

    gap: tuple[float, ...] = axis(
        GAP, f"Gaps: {_RANGE}.", '{start = "0 mm", stop = "100 mm", num = 51}', "that of the interface"
    ).defaults_to(())
    interface: str = text(
        "The only interface of a row whose gap varies, by its buildings.", "frame | masonry", "all vary alike"
    ).defaults_to("")
    yield_force: tuple[float, ...] = axis(
        YIELD_FORCE, f"Yield forces: {_RANGE}.", '["200 kN", "400 kN", "inf"]', "that of the interface"
    ).defaults_to(())
    contact_model: tuple[str, ...] = LAW_NAMES.defaults_to(())
    pga: tuple[float, ...] = axis(PGA, f"PGAs: {_RANGE}.", '["0.2 g", "0.5 g"]', "that of the records").defaults_to(())
    axes: dict[str, Any] = NUMBERS.defaults_to({})
    zip: tuple[tuple[str, ...], ...] = TOGETHER.defaults_to(())

    def written(self) -> dict[str, Any]:
        """The keys that are given, as a scene file has them: an axis of numbers stands beside the other keys."""
        written = super().written()
        return written | written.pop("axes", {})


class Solver(Table):
    """How exactly the runs are solved."""

    rtol: float = measured(RTOL, "Relative tolerance of every run.", absent="1e-6").defaults_to(1e-6)


# ------------------------------------------------------------------------------------------------ effects


class Effect(NamedTuple):
    """One effect that the scene names, with its options.

    Parameters
    ----------
    name : str
        Its name, as in [effects].
    options : tuple of (str, value)
        Its options in SI; of a new scene a dict too, with text and units.
    """

    name: str
    options: tuple[tuple[str, Any], ...] = ()

    def written(self) -> dict[str, Any]:
        """The options as a scene file has them: quantities as text, exact."""
        kinds = EFFECTS[self.name].options
        return {
            key: written_option(option, kinds[key]) if isinstance(kinds[key], Quantity) else option
            for key, option in self.options
        }


def effect_key(name: str) -> Key:
    """The key of an effect in [effects], from its class."""
    kind: Any = EFFECTS[name]
    left_out = "; ".join(f"{key} left out: {default_example(name, key)}" for key in kind.optional)
    return Key(
        (kind.__doc__ or "").partition("\n")[0],
        lambda value, number: _read_effect(name, value, number),
        f"{{{_keys_text(kind, True)}}}",
        f"does not act{'; ' if left_out else ''}{left_out}",
        write=lambda effect: effect.written(),
        schema={
            "type": "object",
            "properties": {key: _schema(allowed, default_example(name, key)) for key, allowed in kind.options.items()},
            "required": [key for key in kind.options if key not in kind.optional],
            "additionalProperties": False,
        },
    )


def _read_effect(name: str, value: Any, number: Number) -> Effect:
    """An effect from the table of its options."""
    kind: Any = EFFECTS[name]
    if not isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is not a table; write {name} = {{{_keys_text(kind)}}}, or remove it")
    kinds = {
        key: lambda item, allowed=allowed: _setting(item, allowed, number) for key, allowed in kind.options.items()
    }
    needed = [key for key in kinds if key not in kind.optional]
    takes = f"{name} takes {_keys_text(kind, True) or 'no keys'}"
    values = options(value, kinds, needed, lambda key: f"missing; write {name} = {{{_keys_text(kind)}}}", takes)
    return Effect(name, tuple(sorted({**defaults(name), **values}.items())))


def _setting(value: Any, allowed: Any, number: Number) -> Any:
    if isinstance(allowed, Quantity):
        return read_option(value, allowed, number)
    if value not in allowed:
        hint = nearest(value, allowed)
        raise Unreadable(f"{shown(value)} is not one of {', '.join(map(shown, allowed))}{hint}; write one of these")
    return value


def _keys_text(kind: Any, with_optional: bool = False) -> str:
    """An effect's keys as a scene has them, each with an example; optional ones too if ``with_optional``."""
    shown_keys = {key: allowed for key, allowed in kind.options.items() if with_optional or key not in kind.optional}
    return ", ".join(f"{key} = {option_example(allowed)}" for key, allowed in shown_keys.items())


def _schema(allowed: Quantity | tuple[str, ...], absent: str) -> dict[str, Any]:
    """An option of an effect in the schema."""
    notes = {"x-example": option_example(allowed), "x-absent": absent}
    if not isinstance(allowed, Quantity):
        return {"enum": list(allowed), **notes}
    kind: Any = ["number", "string"] if allowed.unit == "1" else "string"
    kind = ["string", "array"] if isinstance(allowed, PerInterface) else kind
    words = f"{allowed.words[0].upper()}{allowed.words[1:]}."
    return {"type": kind, "description": words, **facts(allowed), **notes}


def option_example(allowed: Quantity | tuple[str, ...]) -> str:
    """An example of an option that takes a quantity, or one of these words."""
    return written_example(allowed) if isinstance(allowed, Quantity) else shown(allowed[-1])


def effect_tables(effects: Any) -> Any:
    """[effects] of what Python gives: a dict of names and options, or a list of names and `Effect`."""
    if isinstance(effects, list | tuple) and all(isinstance(effect, str | Effect) for effect in effects):
        pairs = ((effect, {}) if isinstance(effect, str) else effect for effect in effects)
        effects = {name: dict(settings) for name, settings in pairs}
    if not isinstance(effects, Mapping):
        return effects  # which the reader refuses as no table
    return in_text({name: effect_key(name) for name in effects if name in EFFECTS}, effects)


# ------------------------------------------------------------------------------------------------ checks


def effect_checks(draft: Draft) -> Iterator[Fault]:
    """Faults for effects that lack what they act on, or do not act on a contact model; floors without a length."""
    names = [keys.raw.get("contact_model") for keys in draft.tables("interface")]
    laws = known_models([*names, *as_list(draft.table("grid").raw.get("contact_model"))])
    users = [name for name in laws if needs_floors(CONTACT_MODELS[name])]
    for keys in draft.tables("building") if users else ():
        if keys.kind is not RigidWall and "floor_length" not in keys:
            yield keys.fault(
                "floor_length",
                f'missing, and {users[0]} needs it; write floor_length = "20 m", the length of the floor along the row',
                absent=True,
            )
    keys = draft.table("effects")
    effects = {name: setting for name, setting in keys.raw.items() if name in EFFECTS}
    for name, setting in effects.items():
        kind: Any = EFFECTS[name]
        for source in kind.needs:
            if source not in effects:
                yield keys.fault(name, f"acts on what {source} leaves; write {source} = {{}} as well")
        if isinstance(setting, dict) and setting.get("code") == "mc1990" and "strength" not in setting:
            yield keys.fault(name, 'code mc1990 needs the concrete; write strength = "30 MPa" as well')
        for law in laws:
            if why := refusal(CONTACT_MODELS[law], name):
                models = ", ".join(other for other, kind in LAWS.items() if not refusal(kind))
                yield keys.fault(name, f"{law} {why}; remove {name}, or choose among {models}")
    exponents = [keys.raw.get("plastic_exponent", 0) for keys in draft.tables("interface")]
    if "permanent_set" in effects and "van_mier" in laws and any(n not in (0, 0.0, "0") for n in exponents):
        yield keys.fault(
            "permanent_set",
            "van_mier with a plastic_exponent above 0 hardens while it yields, and what it remembers of that is not "
            "published; remove plastic_exponent, or permanent_set",
        )
