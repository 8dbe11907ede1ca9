"""Files for the tools around this one, written from the dataset of a scan: a module of this folder for each format.

A module states ``WORDS`` (what the file is), ``ENDINGS`` of its name, and has ``write(results, target, asked)``, which
returns the files that it wrote and sentences on what they do not hold. Its name is that of the format.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import TYPE_CHECKING

from pounding_risk._common.words import nearest
from pounding_risk.assessment.demands import check_dataset, open_dataset
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports._written import Asked, Written
from pounding_risk.units import GAP, PGA, shown, si

if TYPE_CHECKING:
    import xarray as xr


def formats() -> dict[str, ModuleType]:
    """The formats by name."""
    names = sorted(module.name for module in iter_modules(__path__) if not module.name.startswith("_"))
    return {name: import_module(f"{__name__}.{name}") for name in names}


def known_format(name: str) -> ModuleType:
    """The format of a name; raises PoundingError for another word."""
    known = formats()
    if name not in known:
        listed = "; ".join(f"{key} ({module.WORDS})" for key, module in known.items())
        raise PoundingError(f"--to: {shown(name)} is no format{nearest(name, known)}; it may be {listed}")
    return known[name]


def export(
    results: xr.Dataset | str | Path,
    to: str,
    target: str | Path,
    *,
    of: str = "contact",
    gap: float | str | None = None,
    pga: float | str | None = None,
    intensity: str | None = None,
    discrete: bool = False,
) -> Written:
    """Write what a dataset of `scan` holds as a file of another tool.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`, or the file it is in.
    to : str
        The format: ``nrml``, ``pelicun`` or ``csv``.
    target : str or Path
        The file to write; of pelicun a folder.
    of : {"contact", "yield"}
        What the fragilities are of.
    gap : float or str, optional
        The gap of the fragilities [m, or text with a unit]; that of the scene by default.
    pga : float or str, optional
        Amplitude of the grid whose demands are written [m/s2, or text with a unit]; as of `assess`.
    intensity : str, optional
        Intensity of the fragilities; as of `assess`.
    discrete : bool
        Write probabilities at intensities instead of the parameters of the lognormal curve.

    Returns
    -------
    Written
        The files, and sentences on what they do not hold.

    Raises
    ------
    PoundingError
        For an unknown format, a name that it cannot have, results that hold nothing for it, and as `assess`.
    """
    module = known_format(to)
    file = Path(target)
    if file.suffix.lower() not in module.ENDINGS:
        endings = " or ".join(module.ENDINGS)
        kind = f"a file that ends in {endings}" if endings else "a folder, a name without an ending"
        raise PoundingError(f"{file}: {to} is {kind}; choose another name")
    opened, source = open_dataset(results)
    check_dataset(opened, source)
    asked = Asked(
        of,
        None if gap is None else si(gap, GAP._replace(open_high=True), "gap"),
        None if pga is None else si(pga, PGA, "pga"),
        intensity,
        discrete,
    )
    written: Written = module.write(opened, file, asked)
    return written
