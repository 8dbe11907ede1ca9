"""The key `hysteresis` of a building: an inline table with the law by which its storeys yield."""

from __future__ import annotations

from dataclasses import fields
from math import inf
from typing import Any

from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.hysteresis import RULES, Hysteresis
from pounding_risk.scene.keys import Key, Number, Several, Table, Unreadable, inline, list_of, measured, one_of
from pounding_risk.scene.not_modelled import RULES_ELSEWHERE
from pounding_risk.scene.toml import KeyPath
from pounding_risk.units import Quantity, shown

MULTIPLE = Quantity("1", 0.0, inf, "multiple of yield", open_low=True, open_high=True, example="4.0")
SHARE = Quantity("1", 0.0, 1.0, "share", open_low=True, example="0.3")
UNLOADING = Quantity("1", 0.0, 1.0, "exponent of unloading", open_high=True, example="0.4")
CAPACITY = MULTIPLE._replace(words="energy over yield shear times yield drift", example="60")
EXPONENT = MULTIPLE._replace(words="exponent", example="1.0")
SHARPNESS = Quantity("1", 1.0, 20.0, "exponent of Bouc and Wen", example="2")
LOSS = Quantity("1", 0.0, inf, "degradation", open_high=True, example="0.01")
EXAMPLE = '{rule = "peak_oriented", backbone = [[4.0, 1.15], [12.0, 0.3]], unloading = 0.4, energy_capacity = 60}'
_POINTS = "points past yield, each [drift, shear] in multiples of those at yield, such as [[4.0, 1.15], [12.0, 0.3]]"

OF_STOREYS = {name: rule for name, rule in RULES.items() if rule.USE == "storey"}
RULE = one_of(
    list(OF_STOREYS),
    "a rule of hysteresis",
    "What follows a turn: " + "; ".join(f"{name}: {rule.WORDS}" for name, rule in OF_STOREYS.items()) + ".",
    '"peak_oriented"',
    missing=f'missing; write rule = "peak_oriented", or another of {", ".join(OF_STOREYS)}',
    elsewhere=RULES_ELSEWHERE,
)


def _backbone(value: Any, number: Number) -> tuple[tuple[float, float], ...]:
    points = list_of(value, _POINTS)
    if not all(isinstance(point, list | tuple) and len(point) == 2 for point in points):
        raise Unreadable(f"{shown(value)} is no backbone; write {_POINTS}")
    return tuple((number(drift, MULTIPLE), number(shear, MULTIPLE)) for drift, shear in points)


class HysteresisTable(Table):
    """How the storeys of a building yield under the effect `inelastic_storeys`: a backbone and a rule.

    Numbers are multiples of each storey's yield drift, storey_strengths over storey_stiffnesses, and yield shear.
    """

    rule: str = RULE.required()
    backbone: tuple[tuple[float, float], ...] = Key(
        "Points of the backbone past yield, [drift, shear] each, the same in both directions; past the last one "
        "the shear stays.",
        _backbone,
        "[[4.0, 1.15], [12.0, 0.3]]",
        "a straight line by hardening of inelastic_storeys",
        write=lambda points: [list(point) for point in points],
        schema={"type": "array", "items": {"type": "array", "items": {"type": "number"}}},
    ).defaults_to(())
    pinching_drift: float = measured(
        SHARE,
        "Of peak_oriented: how far from the start of reloading to the elastic line through its target the pinch "
        "point lies; the smaller, the earlier the storey stiffens again.",
        "0.5",
        "1",
    ).defaults_to(1.0)
    pinching_force: float = measured(
        SHARE, "Of peak_oriented: shear at the pinch point over that at the target.", absent="no pinching"
    ).defaults_to(1.0)
    unloading: float = measured(
        UNLOADING,
        "Of peak_oriented: exponent with which the stiffness of unloading falls with ductility.",
        absent="0, the elastic stiffness",
    ).defaults_to(0.0)
    energy_capacity: float = measured(
        CAPACITY,
        "Of peak_oriented: energy that a storey dissipates until it has no strength left, over its yield shear "
        "times its yield drift; strength falls with each half cycle.",
        absent="strength is kept",
    ).defaults_to(inf)
    energy_exponent: float = measured(
        EXPONENT, "Of peak_oriented: exponent c of the loss of strength.", "1.5", "1"
    ).defaults_to(1.0)
    exponent: float = measured(
        SHARPNESS, "Of bouc_wen: exponent n, the sharpness of the knee.", absent="1"
    ).defaults_to(1.0)
    beta: float = measured(
        SHARE._replace(example="0.5"), "Of bouc_wen: β, by which unloading is stiffer.", absent="0.5"
    ).defaults_to(0.5)
    delta_a: float = measured(
        LOSS, "Of bouc_wen: loss of A with the energy taken over that at yield.", "0.005", "0"
    ).defaults_to(0.0)
    delta_nu: float = measured(LOSS, "Of bouc_wen: growth of ν, loss of strength.", absent="0").defaults_to(0.0)
    delta_eta: float = measured(LOSS, "Of bouc_wen: growth of η, loss of stiffness.", "0.02", "0").defaults_to(0.0)
    collapse_drift: float = measured(
        SHARE._replace(words="drift over height", example="0.1"),
        "Drift over storey height at which a storey has collapsed and its run ends.",
        absent="0.2",
    ).defaults_to(0.2)

    @classmethod
    def of(cls, hysteresis: Hysteresis) -> Any:
        """The table of a law, what differs from the defaults stated."""
        usual = {field.name: field.default for field in fields(Hysteresis)}
        parameters = {key: getattr(hysteresis, key) for key in cls.key_names()}
        return cls.from_values({key: parameter for key, parameter in parameters.items() if parameter != usual[key]})

    def law(self) -> Hysteresis:
        """The hysteresis as storeys of `models.structures` have it."""
        return Hysteresis(**{key: getattr(self, key) for key in self.key_names()})


def _hysteresis(value: Any, number: Number) -> HysteresisTable:
    """A table whose backbone and parameters are those of its rule."""
    table: HysteresisTable = inline(HysteresisTable, "hysteresis", value, number, EXAMPLE)
    keys_of_rule = ("rule", "backbone", "collapse_drift", *RULES[table.rule].OPTIONS)
    takers = {key: name for name, rule in RULES.items() for key in rule.OPTIONS}
    faults: list[tuple[KeyPath, str]] = [
        ((key,), f'rule = "{table.rule}" has no {key}; remove it, or write rule = "{takers[key]}"')
        for key in table.key_names()
        if key not in keys_of_rule and getattr(table, key) != HysteresisTable.model_fields[key].default
    ]
    try:
        table.law()
    except PoundingError as error:
        faults.append((("backbone",), str(error).removeprefix("backbone: ")))
    if faults:
        raise Several(faults)
    return table


HYSTERESIS = Key(
    "How its storeys yield under inelastic_storeys: a backbone of several branches, and what follows a turn.",
    _hysteresis,
    EXAMPLE,
    "bilinear, with kinematic hardening",
    write=lambda table: table.written(),
    schema={"$ref": "#/$defs/HysteresisTable"},
)
