"""Fragilities as an OpenQuake NRML 0.5 fragility model.

``mean`` and ``stddev`` of NRML are those of the intensity, not of its logarithm: of a median θ and a dispersion β they
are θ exp(β²/2) and the mean times sqrt(exp(β²) − 1).
"""

from __future__ import annotations

from math import ceil, exp, log, sqrt
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import xarray as xr

from pounding_risk._common.dates import created
from pounding_risk._common.written import write_files
from pounding_risk.reports.exports import Options, Written
from pounding_risk.reports.exports._fragilities import TAIL, Fragilities, Function, Model, distinct, fragilities_of
from pounding_risk.statistics.fragility import fragility_curve

WORDS = "OpenQuake fragility model, NRML 0.5"
ENDINGS = (".xml",)
SOURCE = "results"
OF_DAMAGE = True
TAKES = ("of", "gap", "pga", "intensity_level", "intensity", "method", "discrete", "without")
NAMESPACE = "http://openquake.org/xmlns/nrml/0.5"
LEVELS = 33  # of a discrete curve within its range, evenly in the logarithm
MOST_LEVELS = 257
LONGEST_MODEL = 75  # characters of the identifier of a model


def write(results: xr.Dataset, target: Path, options: Options) -> Written:
    """Write the fragilities of one kind of failure, a file for each model; raises PoundingError for none."""
    fragilities = fragilities_of(results, options)
    notes = [*fragilities.notes]
    files = [target]
    if len(fragilities.models) > 1:
        names = distinct(model.identifier for model in fragilities.models)
        files = [target.with_name(f"{target.stem}-{name}{target.suffix}") for name in names]
        notes.append("OpenQuake takes one model from a file, with the same limit states for all its functions")
    side = " without pounding" if options.without else ""
    documents = (document(fragilities, model, side, options.discrete) for model in fragilities.models)
    paths = write_files(zip(files, documents, strict=True))
    notes += [
        "probabilities are those of the fitted lognormal; its standard errors are in the description",
        "the curves count no uncertainty of the buildings",
    ]
    return Written(paths, tuple(notes))


def document(fragilities: Fragilities, model: Model, side: str, discrete: bool) -> str:
    """The text of a fragility model."""
    root = Xml.Element("nrml", xmlns=NAMESPACE)
    attributes = {"id": f"pounding_{model.identifier}"[:LONGEST_MODEL], "assetCategory": "buildings"}
    element = Xml.SubElement(root, "fragilityModel", attributes | {"lossCategory": "structural"})
    Xml.SubElement(element, "description").text = _description(fragilities, model, side)
    Xml.SubElement(element, "limitStates").text = " ".join(model.states)
    for function in model.functions:
        form = {"format": "discrete"} if discrete else {"format": "continuous", "shape": "logncdf"}
        (_add_discrete if discrete else _add_continuous)(
            Xml.SubElement(element, "fragilityFunction", {"id": function.identifier, **form}),
            function,
            fragilities.measure.imt,
        )
    Xml.indent(root, " ")
    return f"{Xml.tostring(root, encoding='utf-8', xml_declaration=True).decode()}\n"


def _add_continuous(element: Xml.Element, function: Function, imt: str) -> None:
    """Mean and deviation of the intensity at each limit state, not of its logarithm."""
    low, high = function.ends
    Xml.SubElement(element, "imls", {"imt": imt, "minIML": f"{low:.6g}", "maxIML": f"{high:.6g}"})
    for curve in function.curves:
        mean = curve.median * exp(0.5 * curve.dispersion**2)
        spread = mean * sqrt(exp(curve.dispersion**2) - 1.0)
        Xml.SubElement(element, "params", {"ls": curve.state, "mean": repr(mean), "stddev": repr(spread)})


def _add_discrete(element: Xml.Element, function: Function, imt: str) -> None:
    """Probabilities at intensities of the range; no limit of no damage is stated, which would cut the curve."""
    low, high = function.ends
    narrowest = min(curve.dispersion for curve in function.curves)
    count = ceil((LEVELS - 1) * log(high / low) / (2.0 * TAIL * narrowest) - 1e-9) + 1
    level_texts = [f"{level:.6g}" for level in np.geomspace(low, high, min(count, MOST_LEVELS))]
    Xml.SubElement(element, "imls", {"imt": imt}).text = " ".join(level_texts)
    for curve in function.curves:
        shares = fragility_curve(np.array(level_texts, dtype=float), curve.median, curve.dispersion)
        Xml.SubElement(element, "poes", {"ls": curve.state}).text = " ".join(f"{share:.8g}" for share in shares)


def _description(fragilities: Fragilities, model: Model, side: str) -> str:
    """What the curves are, each with its median and dispersion, and the motions that they are from."""
    texts = "; ".join(
        f"{function.identifier}, {curve.state}: {curve.words}, median {curve.median:.4g} {fragilities.measure.unit} "
        f"(standard error of its logarithm {curve.errors[0]:.2g}), dispersion {curve.dispersion:.3g} "
        f"({curve.errors[1]:.2g}), {curve.runs} runs"
        for function in model.functions
        for curve in function.curves
    )
    return f"{fragilities.title}{side}. {texts}. {created('pounding_risk.export')['history']}"
