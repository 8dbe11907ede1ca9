"""Strings of the GEM Building Taxonomy 3.3: read for typology and storeys, and written with position and pounding.

Atoms and their titles are those of json/taxonomy3.3_standard.json of gem/gem_taxonomy. Read are material, lateral
system, level of the code, height and year; the rest is kept as it is written. Of version 2, HEX and HBET are read too.

    >>> [str(attribute) for attribute in read_taxonomy("CR/LFINF(MUR)+CDM/H:6")]
    ['CR', 'LFINF(MUR)+CDM', 'H:6']
    >>> with_found("CR/LFM/H:6/RES/IRI+IRV(SOS)", "BP2", True)
    'CR/LFM/H:6/RES/BP2/IRI+IRV(SOS;POP)'
"""

from __future__ import annotations

import re
from typing import NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.streets.hazus import FAMILIES
from pounding_risk.streets.inventory._lines import FIRST_YEAR, LAST_YEAR, Draft, Kind
from pounding_risk.units import shown

UNKNOWN = "UNK"
DEEPEST = 4  # brackets in brackets; the standard has two
LONGEST = 500  # characters
TOKEN = re.compile(r"[A-Z][A-Z0-9]*|[()/+;]|:[A-Za-z0-9<>-][A-Za-z0-9.,-]*")
EXAMPLE = "CR/LFM+CDM/H:6"
# First atoms of the attributes before the position within a block, in the standard's order.
MATERIALS = ("C", "CU", "CR", "SRC", "S", "ME", "M", "MUR", "MCF", "MR", "E", "EU", "ER", "W")
CONCRETE, STEEL, MASONRY = ("C", "CU", "CR", "SRC"), ("S", "ME"), ("M", "MUR", "MCF", "MR", "E", "EU", "ER")
SYSTEMS = ("LN", "LFM", "LFINF", "LFBR", "LPB", "LWAL", "LDUAL", "LFLS", "LFLSINF", "LO")
BEFORE = (
    *("MDD", *MATERIALS, "HYB", "INF", "MATO"),
    *("LDD", "LHV", *SYSTEMS, "CDN", "CDL", "CDM", "CDH"),
    *("LFC", "DNO", "DUL", "DUM", "DUH", "DBD", "DCW"),
    *("H", "HAPP", "HEX", "HBET", "HHT", "HHI", "HB", "HBEX", "HBAPP", "HF", "HFAPP", "HD"),
    *("Y", "YAPP", "YMP", "YMM", "YMG"),
    *("NONRES", "RES", "COM", "MIX", "IND", "AGR", "ASS", "GOV", "EDU", "HEA", "TRT", "OCO"),
)
LEVELS = {"CDN": "pre", "CDL": "low", "CDM": "moderate", "CDH": "high"}
POSITIONS = ("BPD", "BP1", "BP2", "BP3")
POUNDING = "POP"
IRREGULAR, VERTICAL, REGULAR = "IRI", "IRV", "IRR"
# Family of Hazus and typology of a material and a system; a masonry building has no frame.
FRAMES = {
    ("concrete", "LFM"): "C1",
    ("concrete", "LFINF"): "C3",
    ("concrete", "LWAL"): "C2",
    ("concrete", "LDUAL"): "C2",
    ("steel", "LFM"): "S1",
    ("steel", "LFBR"): "S2",
    ("steel", "LFINF"): "S5",
    ("steel", "LWAL"): "S4",
    ("steel", "LDUAL"): "S4",
    ("wood", "LWAL"): "W1",
    ("wood", "LPB"): "W2",
}


class Atom(NamedTuple):
    """A word of a string with its arguments in brackets and its parameters behind colons."""

    name: str
    arguments: tuple[Attribute, ...] = ()
    parameters: tuple[str, ...] = ()

    def __str__(self) -> str:
        inner = f"({';'.join(map(str, self.arguments))})" if self.arguments else ""
        return self.name + inner + "".join(f":{parameter}" for parameter in self.parameters)


class Attribute(NamedTuple):
    """Atoms joined by +: all that a string says of the material, of the height, and so on."""

    atoms: tuple[Atom, ...]

    def __str__(self) -> str:
        return "+".join(map(str, self.atoms))


def read_taxonomy(text: str) -> tuple[Attribute, ...]:
    """The attributes of a string; raises PoundingError where its brackets and signs make none."""
    tokens = TOKEN.findall(text) if len(text) <= LONGEST else []
    if "".join(tokens) != text or not tokens:
        raise PoundingError(f'{shown(text[:80])} is no string of the GEM taxonomy; write one such as "{EXAMPLE}"')
    if tokens == [UNKNOWN]:
        return ()
    attributes, end = _attributes(tokens, 0, "/", 0)
    if end != len(tokens):
        raise PoundingError(f'{shown(text)} has a "{tokens[end]}" too many, or out of place; write as "{EXAMPLE}"')
    return attributes


def _attributes(tokens: list[str], index: int, sign: str, depth: int) -> tuple[tuple[Attribute, ...], int]:
    """Attributes joined by a sign from a token on, and where they end."""
    attributes = []
    while True:
        atoms, index = _atoms(tokens, index, depth)
        attributes.append(Attribute(atoms))
        if index == len(tokens) or tokens[index] != sign:
            return tuple(attributes), index
        index += 1


def _atoms(tokens: list[str], index: int, depth: int) -> tuple[tuple[Atom, ...], int]:
    atoms: list[Atom] = []
    while True:
        if index == len(tokens) or not tokens[index][0].isalpha() or depth > DEEPEST:
            raise PoundingError(f'{shown("".join(tokens))}: a word is missing; write as "{EXAMPLE}"')
        name = tokens[index]
        arguments: tuple[Attribute, ...] = ()
        index += 1
        if index < len(tokens) and tokens[index] == "(":
            arguments, index = _attributes(tokens, index + 1, ";", depth + 1)
            if index == len(tokens) or tokens[index] != ")":
                raise PoundingError(f'{shown("".join(tokens))}: a bracket is not closed; write as "LFINF(MUR)"')
            index += 1
        parameters = []
        while index < len(tokens) and tokens[index][0] == ":":
            parameters.append(tokens[index][1:])
            index += 1
        atoms.append(Atom(name, arguments, tuple(parameters)))
        if index == len(tokens) or tokens[index] != "+":
            return tuple(atoms), index
        index += 1


def with_found(text: str, position: str, has_pounding: bool) -> str:
    """A string with the position in its block, and with POP where buildings pound.

    Without a position, "", that of the string is kept, and a POP that it has is kept in any case.
    """
    attributes = list(read_taxonomy(text)) if text else []
    shape = next((item for item in attributes if item.atoms[0].name.startswith(("PLF", "BP"))), None)
    irregular = next((item for item in attributes if item.atoms[0].name in (REGULAR, IRREGULAR)), None)
    attributes = [item for item in attributes if item not in (shape, irregular)]
    last = max((n for n, item in enumerate(attributes, 1) if item.atoms[0].name in BEFORE), default=0)
    other_atoms = tuple(atom for atom in (shape.atoms if shape else ()) if not position or atom.name not in POSITIONS)
    written = [Attribute((*other_atoms, *((Atom(position),) if position else ())))] if other_atoms or position else []
    if has_pounding:
        atoms = irregular.atoms if irregular else ()
        vertical = next((atom for atom in atoms if atom.name == VERTICAL), Atom(VERTICAL))
        other_names = (atom for atom in atoms if atom.name not in (REGULAR, IRREGULAR, VERTICAL))
        pounding = Attribute((Atom(POUNDING),))
        arguments = vertical.arguments if pounding in vertical.arguments else (*vertical.arguments, pounding)
        written.append(Attribute((Atom(IRREGULAR), *other_names, Atom(VERTICAL, arguments))))
    elif irregular:
        written.append(irregular)
    return "/".join(map(str, [*attributes[:last], *written, *attributes[last:]])) or UNKNOWN


def kind_of(attributes: tuple[Attribute, ...]) -> Kind | None:
    """Typology and family of material and lateral system; None where the string says neither."""
    names = [atom.name for attribute in attributes for atom in attribute.atoms]
    material = next((name for name in names if name in MATERIALS), "")
    system = next((name for name in names if name in SYSTEMS), "")
    if not material:
        return None
    taxonomy_words = f"{material} {system}".strip()
    if material in MASONRY:
        family = "URM" if material in ("MUR", "E", "EU") else ""
        return Kind(family, "masonry", FAMILIES[family].words if family else f"{taxonomy_words}, masonry")
    material_name = "concrete" if material in CONCRETE else "steel" if material in STEEL else "wood"
    family = FRAMES.get((material_name, system), "")
    if not family:
        return Kind("", "", f"{taxonomy_words}, {material_name} of an unknown system")
    return Kind.of_hazus(family)


def put_taxonomy(draft: Draft, text: str, head: str) -> str:
    """Set the columns that follow from a string, and return it; "" with a fault where it is no taxonomy."""
    try:
        attributes = read_taxonomy(text)
    except PoundingError as error:
        draft.fault(head, str(error))
        return ""
    kind = kind_of(attributes)
    if kind is not None:
        draft.kind(kind, f"{head} {text}")
    # The height of a storey counts with the number of storeys, wherever that stands.
    for atom in sorted((atom for item in attributes for atom in item.atoms), key=lambda atom: atom.name == "HHI"):
        if atom.name in LEVELS:
            draft.put("code level", LEVELS[atom.name], rule=f"its {head}, {atom.name}")
        elif atom.name in ("H", "HEX", "HAPP", "HBET") and "storeys" not in draft.values:
            _put_storeys(draft, atom, head)
        elif atom.name in ("HHT", "HHI") and atom.parameters and "height" not in draft.values:
            number = atom.parameters[0]
            height = float(number) if re.fullmatch(r"\d{1,6}(\.\d*)?", number) else 0.0
            storeys = 1 if atom.name == "HHT" else draft.values.get("storeys")
            if not 0.0 < height < 1e3:
                draft.fault(head, f"{atom} gives no height in m; write HHT:18.5")
            elif storeys:
                draft.put("height", height * storeys, f"{height * storeys:g} m", f"its {head}, {atom}")
    return text


def _put_storeys(draft: Draft, atom: Atom, head: str) -> None:
    """The storeys of an atom: a number, or the middle of a range, rounded up."""
    numbers = [int(number) for number in re.findall(r"\d{1,6}", atom.parameters[0] if atom.parameters else "")]
    if not 1 <= len(numbers) <= 2 or not 1 <= max(numbers) <= MOST_STOREYS:
        draft.fault(head, f"{atom} gives no storeys from 1 to {MOST_STOREYS}; write H:6")
    elif re.search("[<>]", atom.parameters[0]):
        draft.note(f"{atom} in its {head} bounds the storeys and gives no number; it is not read")
    else:
        middle = max(-(-sum(numbers) // len(numbers)), 1)
        is_estimate = len(numbers) > 1 or atom.name == "HAPP"
        draft.put("storeys", middle, rule=f"its {head}, {atom}" if is_estimate else "")


def year_of(text: str) -> int | None:
    """The year that a string gives, exactly or about; None where it gives none."""
    years = re.findall(r"(?:^|[/+])Y(?:APP)?:(\d{4})(?=$|[/+])", text)
    return next((int(year) for year in years if FIRST_YEAR <= int(year) <= LAST_YEAR), None)
