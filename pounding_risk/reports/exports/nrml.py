"""Fragilities as an OpenQuake NRML 0.5 fragility model.

``mean`` and ``stddev`` of NRML are those of the intensity, not of its logarithm: of a median θ and a dispersion β they
are θ exp(β²/2) and the mean times sqrt(exp(β²) − 1).
"""

from __future__ import annotations

from io import BytesIO
from math import exp, sqrt
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as Xml

import numpy as np

from pounding_risk.reports.exports._curves import Curve, Curves, curves_of, probabilities
from pounding_risk.reports.exports._written import Asked, Written, write_file

if TYPE_CHECKING:
    import xarray as xr

WORDS = "OpenQuake fragility model, NRML 0.5"
ENDINGS = (".xml",)
SOURCE = "results"
TAKES = ("of", "gap", "pga", "intensity_level", "intensity", "discrete")
NAMESPACE = "http://openquake.org/xmlns/nrml/0.5"
STATES = {"contact": "contact", "yield": "yielding"}
TAIL = 4.0  # dispersions on either side of the median that a curve is written for: 0.003 % and 99.997 %
LEVELS = 33  # of a discrete curve, evenly in the logarithm


def write(results: xr.Dataset, target: Path, asked: Asked) -> Written:
    """Write the fragilities of one kind of failure; raises PoundingError where there are none."""
    found = curves_of(results, asked)
    told = (
        *found.told,
        "probabilities are those of the fitted lognormal; its standard errors are in the description",
        "the curves count no uncertainty of the buildings",
    )
    return Written((write_file(target, document(found, asked.discrete)),), told)


def document(found: Curves, discrete: bool) -> str:
    """The text of a fragility model."""
    state = STATES[found.kind]
    root = Xml.Element("nrml", xmlns=NAMESPACE)
    about = {"id": f"pounding_{state}", "assetCategory": "buildings", "lossCategory": "structural"}
    model = Xml.SubElement(root, "fragilityModel", about)
    Xml.SubElement(model, "description").text = _description(found)
    Xml.SubElement(model, "limitStates").text = state
    for curve in found.curves:
        form = {"format": "discrete"} if discrete else {"format": "continuous", "shape": "logncdf"}
        function = Xml.SubElement(model, "fragilityFunction", {"id": curve.identifier, **form})
        low, high = (curve.median * exp(side * TAIL * curve.dispersion) for side in (-1.0, 1.0))
        if discrete:
            _add_discrete(function, curve, found.measure.imt, state)
            continue
        limits = {"minIML": f"{low:.6g}", "maxIML": f"{high:.6g}"}
        Xml.SubElement(function, "imls", {"imt": found.measure.imt, **limits})
        mean = curve.median * exp(0.5 * curve.dispersion**2)
        spread = mean * sqrt(exp(curve.dispersion**2) - 1.0)
        Xml.SubElement(function, "params", {"ls": state, "mean": repr(mean), "stddev": repr(spread)})
    Xml.indent(root, " ")
    out = BytesIO()
    Xml.ElementTree(root).write(out, encoding="utf-8", xml_declaration=True)
    return f"{out.getvalue().decode()}\n"


def _add_discrete(function: Xml.Element, curve: Curve, imt: str, state: str) -> None:
    """Probabilities at intensities within `TAIL`; no limit of no damage is stated, which would cut the curve."""
    levels = curve.median * np.exp(curve.dispersion * np.linspace(-TAIL, TAIL, LEVELS))
    imls = Xml.SubElement(function, "imls", {"imt": imt})
    written = [f"{level:.6g}" for level in levels]
    imls.text = " ".join(written)
    shares = probabilities(curve, np.array(written, dtype=float))
    Xml.SubElement(function, "poes", {"ls": state}).text = " ".join(f"{share:.8g}" for share in shares)


def _description(found: Curves) -> str:
    """What the curves are, each with its median and dispersion, and the motions that they are from."""
    each = "; ".join(
        f"{curve.identifier}: {curve.words}, median {curve.median:.4g} {found.measure.unit} (standard error of "
        f"its logarithm {curve.errors[0]:.2g}), dispersion {curve.dispersion:.3g} ({curve.errors[1]:.2g}), "
        f"{sum(runs for *_, runs in curve.seen)} runs"
        for curve in found.curves
    )
    from pounding_risk._common.dates import created

    about = str(created("pounding_risk.export")["history"])
    return f"{found.title}. {each}. {about}"
