"""Styles of the layers for QGIS (QML): classes of the probability of contact.

The colour-blind can distinguish them, and so can readers of a print in grey: colours are those of Matplotlib's cividis
from light to dark. The limits are those of the plan of a street.
"""

from __future__ import annotations

from typing import NamedTuple
from uuid import NAMESPACE_URL, uuid5
from xml.etree import ElementTree as Xml

FIELD = "p_contact"
INK, PAPER, UNKNOWN = "#333333", "#ffffff", "#e6e6e6"


class Class(NamedTuple):
    """A class of probabilities: words, the filter that a feature passes, and a colour."""

    words: str
    passes: str
    colour: str


CLASSES = (
    Class("P(contact) 0 %", f'"{FIELD}" = 0', "#ffffff"),
    Class("to 16 %", f'"{FIELD}" > 0 AND "{FIELD}" <= 0.16', "#fee838"),
    Class("to 50 %", f'"{FIELD}" > 0.16 AND "{FIELD}" <= 0.5', "#bcaf6f"),
    Class("to 84 %", f'"{FIELD}" > 0.5 AND "{FIELD}" <= 0.84', "#565c6d"),
    Class("to 100 %", f'"{FIELD}" > 0.84', "#00224e"),
    Class("not known", "ELSE", UNKNOWN),
)


def style(kind: str, label: str) -> str:
    """The style of a layer of ``kind`` "fill", "line" or "marker", with ``label`` an expression of QGIS, as QML."""
    root = Xml.Element("qgis", {"version": "3.22.0", "styleCategories": "Symbology|Labeling", "labelsEnabled": "1"})
    renderer = Xml.SubElement(
        root, "renderer-v2", {"type": "RuleRenderer", "symbollevels": "0", "forceraster": "0", "enableorderby": "0"}
    )
    rules = Xml.SubElement(renderer, "rules", {"key": _key(kind)})
    symbols = Xml.SubElement(renderer, "symbols")
    for number, one in enumerate(CLASSES):
        facts = {"key": _key(f"{kind} {number}"), "symbol": str(number), "label": one.words, "filter": one.passes}
        Xml.SubElement(rules, "rule", facts)
        _add_symbol(symbols, kind, number, one.colour)
    labeling = Xml.SubElement(root, "labeling", {"type": "simple"})
    settings = Xml.SubElement(labeling, "settings", {"calloutType": "simple"})
    text = {"fieldName": label, "isExpression": "1", "fontSize": "8", "fontSizeUnit": "Point"}
    text |= {"textColor": _colour(INK), "textOpacity": "1", "fontFamily": "Sans Serif", "multilineHeight": "1"}
    element = Xml.SubElement(settings, "text-style", text)
    halo = {"bufferDraw": "1", "bufferSize": "0.8", "bufferSizeUnits": "MM", "bufferColor": _colour(PAPER)}
    Xml.SubElement(element, "text-buffer", halo | {"bufferOpacity": "1", "bufferNoFill": "0"})
    placement = {"placement": "1" if kind == "fill" else "0", "dist": "1", "distUnits": "MM"}
    Xml.SubElement(settings, "placement", placement)
    Xml.SubElement(settings, "rendering", {"drawLabels": "1", "obstacle": "1", "fontMaxPixelSize": "10000"})
    Xml.SubElement(root, "layerGeometryType").text = {"marker": "0", "line": "1", "fill": "2"}[kind]
    Xml.indent(root, " ")
    return f"<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n{Xml.tostring(root, encoding='unicode')}\n"


def _key(words: str) -> str:
    """A key of a rule, the same in every file."""
    return f"{{{uuid5(NAMESPACE_URL, f'pounding_risk {words}')}}}"


def _colour(colour: str) -> str:
    """Red, green, blue and opacity, as QGIS writes them."""
    return ",".join(str(int(colour[k : k + 2], 16)) for k in (1, 3, 5)) + ",255"


def _add_symbol(symbols: Xml.Element, kind: str, number: int, colour: str) -> None:
    """The symbol of a class; a line has a dark one below it, on which light colours are seen."""
    attributes = {"type": kind, "name": str(number), "alpha": "1", "clip_to_extent": "1", "force_rhr": "0"}
    symbol = Xml.SubElement(symbols, "symbol", attributes)
    if kind == "line":
        for shade, width in ((INK, "2.2"), (colour, "1.6")):
            options = {"line_color": _colour(shade), "line_width": width, "line_width_unit": "MM"}
            _add_layer(symbol, "SimpleLine", options | {"capstyle": "flat", "joinstyle": "round"})
        return
    outline = {"outline_color": _colour(INK), "outline_style": "solid", "outline_width": "0.3"}
    options = {"color": _colour(colour), **outline, "outline_width_unit": "MM"}
    if kind == "fill":
        _add_layer(symbol, "SimpleFill", options | {"style": "solid", "joinstyle": "miter"})
    else:
        _add_layer(symbol, "SimpleMarker", options | {"name": "square", "size": "5", "size_unit": "MM"})


def _add_layer(symbol: Xml.Element, name: str, options: dict[str, str]) -> None:
    layer = Xml.SubElement(symbol, "layer", {"class": name, "enabled": "1", "locked": "0", "pass": "0"})
    table = Xml.SubElement(layer, "Option", {"type": "Map"})
    for key, option in options.items():
        Xml.SubElement(table, "Option", {"type": "QString", "name": key, "value": option})
