"""Strings of the GEM taxonomy against GEM's own validator: what is read, and what is written back."""

from __future__ import annotations

import random

import pytest
from openquake.gem_taxonomy import GemTaxonomy

from pounding_risk.errors import PoundingError
from pounding_risk.streets.inventory import gem
from pounding_risk.streets.inventory._lines import Draft, Line, Notes
from pounding_risk.streets.inventory.gem import POSITIONS, put_taxonomy, read_taxonomy, with_found, year_of

VALID = (
    "CR/LFM+CDM+DUM/H:6/RES",
    "MDD(CR;S)/LDD(LFM;LWAL)/HAPP:4",
    "HYB(MUR;W)/LFINF(MUR)/H:1-3/Y:<1960",
    "MUR+CLBRS+MOC/LWAL/H:2+HHT:7.5/PLFR+BP2/IRR",
    "W/LPB/IRI+IRP(TOR;REC)+IRV(SOS)/EWMA",
    "S+SR/LFBR/H:12/COM:3/IRI+IRV(POP;SOS)/RSH1",
    "BPD",
    "UNK",
)
OF_VERSION_2 = {"HEX", "HBET", "HBEX", "ASS"}


@pytest.fixture(scope="module")
def standard():
    return GemTaxonomy("3.3")


def atoms_of(attributes):
    """Names of the atoms of a string, those in brackets too."""
    for attribute in attributes:
        for atom in attribute.atoms:
            yield atom.name
            yield from atoms_of(atom.arguments)


def put(text):
    """The values that a string gives, and its faults and notes."""
    faults, notes = [], Notes()
    draft = Draft(Line("line 2", {}), faults, notes)
    put_taxonomy(draft, text, "taxonomy")
    return draft.values, faults, list(notes.sentences())


@pytest.mark.parametrize("text", VALID)
def test_a_string_is_read_as_it_is_written(standard, text):
    standard.validate(text)
    attributes = read_taxonomy(text)
    assert ("/".join(map(str, attributes)) or "UNK") == text


@pytest.mark.parametrize("text", VALID)
@pytest.mark.parametrize("position", POSITIONS)
@pytest.mark.parametrize("has_pounding", [True, False])
def test_what_was_found_is_written_in_the_words_of_the_standard(standard, text, position, has_pounding):
    """Valid, canonical where the string was, and with nothing lost but an earlier position or "regular"."""
    written = with_found(text, position, has_pounding)
    report = standard.validate(written)[2]
    assert report["is_canonical"], report
    atoms = list(atoms_of(read_taxonomy(written)))
    assert [atom for atom in atoms if atom in POSITIONS] == [position]
    assert ("POP" in atoms) == (has_pounding or "POP" in text)
    kept = [atom for atom in atoms_of(read_taxonomy(text)) if atom not in (*POSITIONS, *(["IRR"] * has_pounding))]
    assert set(kept) <= set(atoms) and len(atoms) <= len(kept) + 4
    assert with_found(written, position, has_pounding) == written


def test_without_a_position_and_pounding_a_string_stays(standard):
    for text in VALID:
        assert with_found(text, "", False) == text
    assert with_found("", "BP1", True) == "BP1/IRI+IRV(POP)"
    assert with_found("", "", False) == "UNK"


def test_atoms_that_are_known_are_those_of_the_standard(standard):
    attributes = {atom["name"]: atom["attr"] for atom in standard.tax["Atom"]}
    assert {attributes[name] for name in gem.MATERIALS} == {"material"}
    assert {attributes[name] for name in (*gem.SYSTEMS, *gem.LEVELS)} == {"llrs"}
    assert {attributes[name] for name in POSITIONS} == {"shape"}
    first = {"material", "llrs", "height", "dates", "occupancy"}
    assert {attributes[name] for name in gem.BEFORE if name not in OF_VERSION_2} == first
    types = ("material_type", "type_lateral_load", "building_occupancy_class")
    of_types = {atom["name"] for atom in standard.tax["Atom"] if atom["group"] in types}
    assert of_types <= {*gem.BEFORE}


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("CR/LFM+CDM/H:6", {"typology": "concrete_frame", "hazus type": "C1", "code level": "moderate", "storeys": 6}),
        ("SRC/LDUAL/HAPP:11", {"typology": "concrete_walls", "hazus type": "C2", "storeys": 11}),
        ("CR/LFINF(MUR)+CDN/H:3-6", {"typology": "masonry", "hazus type": "C3", "code level": "pre", "storeys": 5}),
        ("S/LFBR/H:4+HHI:3.5", {"typology": "braced_frame", "hazus type": "S2", "storeys": 4, "height": 14.0}),
        ("S/LFBR/HHI:3.5+H:4", {"typology": "braced_frame", "hazus type": "S2", "storeys": 4, "height": 14.0}),
        ("MUR+ADO/LWAL/HBET:2,1", {"typology": "masonry", "hazus type": "URM", "storeys": 2}),
        ("MCF/LWAL/H:3+HHT:9.5", {"typology": "masonry", "storeys": 3, "height": 9.5}),
        ("W/LWAL/H:2", {"hazus type": "W1", "storeys": 2}),
        ("CR/H:<4", {}),
        ("UNK", {}),
    ],
)
def test_typology_storeys_and_height_follow_from_a_string(text, values):
    found, faults, _ = put(text)
    assert (found, faults) == (values, [])


def test_what_a_string_leaves_open_is_told():
    assert any("bounds the storeys and gives no number" in note for note in put("CR/LFM/H:<4")[2])
    assert any("CR, concrete of an unknown system" in note for note in put("CR/H:4")[2])
    assert year_of("CR/LFM/Y:1987/RES") == 1987 and year_of("CR/Y:<1960") is None and year_of("CR/YAPP:1930") == 1930


@pytest.mark.parametrize("text", ["/M", "M/", "+M", "M++S", "MDD(W", "MDD(W,Z)", "MDD()", "M)", "cr/lfm", "C R", "H:"])
def test_what_is_no_string_is_refused_by_both(standard, text):
    with pytest.raises(ValueError, match=r"\S"):
        standard.validate(text)
    with pytest.raises(PoundingError, match=r'write (one such as "CR/LFM|as "CR/LFM|as "LFINF)'):
        read_taxonomy(text)


def test_storeys_and_heights_out_of_range_are_faults():
    for text, words in [("CR/H:0", "gives no storeys"), ("CR/H:900", "gives no storeys"), ("CR/HHT:0", "no height")]:
        assert words in put(text)[1][0]
    assert "line 2, taxonomy: " in put("CR/")[1][0]


def test_any_text_is_read_or_refused():
    dice = random.Random(7)
    letters = "CRLFMSH:123+/;()UNKIV<>-. é\n"
    for _ in range(3000):
        text = "".join(dice.choice(letters) for _ in range(dice.randint(0, 12)))
        try:
            attributes = read_taxonomy(text)
        except PoundingError as error:
            assert str(error).isprintable()
        else:
            assert ("/".join(map(str, attributes)) or "UNK") == text
    with pytest.raises(PoundingError):
        read_taxonomy("M(" * 200 + ")" * 200)
