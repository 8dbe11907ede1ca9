"""Files for the tools around this one, written from results or scenes: a module of this folder for each format.

A module states ``WORDS`` (what the file is), the ``ENDINGS`` of its name, its ``SOURCE`` ("results" or "scene") and
which options it ``TAKES``, and has ``write(source, target, options)``, which returns the files that it wrote, and
sentences on what they do not hold. One with ``SEVERAL`` gets a list of sources, one with ``OF_DAMAGE`` datasets of
`damage` too. The module's name is that of the format.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, NamedTuple

import xarray as xr

from pounding_risk._common.plugins import Registry
from pounding_risk._common.words import nearest
from pounding_risk._common.written import write_file
from pounding_risk.errors import PoundingError
from pounding_risk.results.check import check_dataset, kind_of
from pounding_risk.results.files import RESULTS, open_with_axes
from pounding_risk.scene.known_motions import check_computed
from pounding_risk.scene.reader import as_scene
from pounding_risk.units import GAP, PGA, shown, si

__all__ = ["Options", "Written", "export", "formats", "known_format", "write_file"]
FACTS = ("WORDS", "ENDINGS", "SOURCE", "TAKES", "write")  # that a format has

if TYPE_CHECKING:
    from pounding_risk.scene.scene import Scene


class Options(NamedTuple):
    """Options of `export`, as they were read."""

    of: str | None = None  # what fragilities are of
    gap: float | None = None  # m
    pga: float | None = None  # m/s2
    intensity_level: float | str | None = None
    intensity: str | None = None
    discrete: bool = False
    without: bool = False  # without pounding
    street: Path | None = None  # footprints of a street
    inventory: Path | None = None  # of the buildings, for their taxonomy
    method: str | None = None  # by which curves of damage states follow from demands


class Written(NamedTuple):
    """Files of an export, and sentences on what is assumed and left out."""

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def formats() -> Mapping[str, Any]:
    """The modules of the formats by their names, those of plug-ins too."""
    names = sorted(module.name for module in iter_modules(__path__) if not module.name.startswith("_"))
    return Registry("writers", {name: _checked(name, import_module(f"{__name__}.{name}")) for name in names}, _checked)


def _checked(name: str, module: Any) -> Any:
    """The format that a module, or a plug-in, is; raises PoundingError for what is none."""
    if lacking := [fact for fact in FACTS if not hasattr(module, fact)]:
        raise PoundingError(f"{module!r} has no {' nor '.join(lacking)}")
    if module.SOURCE not in ("results", "scene"):
        raise PoundingError(f'{module!r}: SOURCE = {module.SOURCE!r}; it may be "results" or "scene"')
    if unknown := set(module.TAKES) - set(Options._fields):
        raise PoundingError(f"{module!r}: TAKES {', '.join(sorted(unknown))}; options are {', '.join(Options._fields)}")
    return module


def known_format(name: str) -> Any:
    """The format of a name; raises PoundingError for another word."""
    known_formats = formats()
    if name not in known_formats:
        choices = "; ".join(f"{key} ({module.WORDS})" for key, module in known_formats.items())
        raise PoundingError(f"--to: {shown(name)} is no format{nearest(name, known_formats)}; it may be {choices}")
    return known_formats[name]


def export(
    source: xr.Dataset | Scene | str | Path | Sequence[xr.Dataset | str | Path],
    to: str,
    target: str | Path,
    *,
    of: str | None = None,
    gap: float | str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
    intensity: str | None = None,
    discrete: bool = False,
    without: bool = False,
    street: str | Path | None = None,
    inventory: str | Path | None = None,
    method: str | None = None,
) -> Written:
    """Write results, or a scene, as files of another tool.

    Parameters
    ----------
    source : xarray.Dataset, Scene, str or Path, or a sequence of datasets or files
        A dataset of `scan` or the file it is in, for ``nrml`` and ``pelicun`` also one of `damage`; of ``opensees`` a
        scene; of ``geopackage`` and ``geoparquet`` one dataset for each row of a street.
    to : str
        The format: ``nrml``, ``pelicun``, ``geopackage``, ``geoparquet``, ``taxonomy``, ``csv`` or ``opensees``.
    target : str or Path
        The file to write; of ``pelicun``, ``geoparquet`` and ``csv`` a folder.
    of : {"contact", "yield", "damage"}, optional
        What the fragilities are of: by default contact, or of ``pelicun`` all that there are.
    gap : float or str, optional
        The gap of fragilities and demands [m, or text with a unit]; that of the scene by default.
    pga : float or str, optional
        Amplitude of the grid whose demands are written [m/s2, or text with a unit]; as of `assess`.
    intensity_level : float or str, optional
        Level of intensity of the grid, in place of ``pga`` where its measure is another; as of `assess`.
    intensity : str, optional
        Intensity of the fragilities; as of `assess`.
    discrete : bool
        Write probabilities at intensities instead of the parameters of the lognormal curve.
    without : bool
        Write the fragilities of damage states without pounding, of each building alone.
    street : str or Path, optional
        Footprints of the buildings for layers: a map as `read_block` takes it, or the buildings.csv of `write_block`.
    inventory : str or Path, optional
        Inventory of the buildings (`streets.read_inventory`), whose strings of the GEM
        taxonomy are written with what was found; matched by name.
    method : {"stripes", "ida", "cloud"}, optional
        How curves of damage states follow from demands, as `damage` takes it; a dataset of `damage` has its own.

    Returns
    -------
    Written
        The files, and sentences on what they do not hold.

    Raises
    ------
    PoundingError
        For an unknown format, a name that its file cannot have, an option that it does not take, results that hold
        nothing for it, a scene that the other program cannot say, layers without the libraries of the extra [maps],
        and as `assess`, `damage` and `read_block`.
    """
    module, file = known_format(to), Path(target)
    if file.suffix.lower() not in module.ENDINGS:
        endings = " or ".join(filter(None, module.ENDINGS))
        kind = f"a file that ends in {endings}" if endings else "a folder, a name without an ending"
        raise PoundingError(f"{target}: {to} is {kind}; choose another name")
    metres = None if gap is None else si(gap, GAP._replace(open_high=True), "gap")
    peak = None if pga is None else si(pga, PGA, "pga")
    outlines, list_of_buildings = (None if name is None else Path(name) for name in (street, inventory))
    options = Options(
        of, metres, peak, intensity_level, intensity, discrete, without, outlines, list_of_buildings, method
    )
    stated_options = [name for name, option in options._asdict().items() if option not in (None, False)]
    if refused := [name for name in stated_options if name not in module.TAKES]:
        raise PoundingError(f"--{refused[0].replace('_', '-')}: has no effect on {to} ({module.WORDS}); leave it out")
    sources = list(source) if isinstance(source, Sequence) and not isinstance(source, str) else [source]
    takes_several = getattr(module, "SEVERAL", False)
    if takes_several and not sources:
        raise PoundingError(f"{to} is written from results, and none are given")
    if not takes_several and len(sources) != 1:
        raise PoundingError(f"{to} is written from one source, and {len(sources)} are given; name one")
    opened = [_opened(item, to, module) for item in sources]
    return module.write(opened if takes_several else opened[0], file, options)


def _opened(source: Any, to: str, module: Any) -> Any:
    """The dataset, or the scene, that a format is made of; raises PoundingError for the other one."""
    if module.SOURCE == "scene":
        if (isinstance(source, str | Path) and Path(source).suffix in RESULTS) or hasattr(source, "data_vars"):
            source_name = str(source) if isinstance(source, str | Path) else "the dataset"
            raise PoundingError(f"{to} is written from a scene, and {source_name} holds results; name the TOML file")
        study = as_scene(source)
        check_computed(study, to)
        return study
    is_scene = (isinstance(source, str | Path) and Path(source).suffix not in RESULTS) or hasattr(source, "interfaces")
    if is_scene:
        scene = source if isinstance(source, str | Path) else getattr(source, "source", "scene.toml")
        raise PoundingError(
            f"{to} is written from results, which {scene} does not hold; `pounding-risk scan {scene} -o results.nc` "
            "writes them"
        )
    opened = open_with_axes(source)
    if kind_of(opened.dataset) != "damage" or not getattr(module, "OF_DAMAGE", False):
        check_dataset(opened.dataset, opened.name, "export")
    return opened.dataset
