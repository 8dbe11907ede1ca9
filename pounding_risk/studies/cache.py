"""The compile cache: where it is, what it holds, and filling it with what scenes need."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import pi, sin
from pathlib import Path
from tempfile import TemporaryDirectory

from pounding_risk._common.counted import counted
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._jit.sources import INTERPRETED, cache_doubt, compile_cache
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.request import RecordRequest
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene

CODE = ".nbc"  # suffix of files with compiled functions; their index has another one
VERSION_FOLDER = re.compile(r"[0-9a-f]{16}")  # name of the folder of one version, a digest of its sources
DT, SHAKING, REST = 0.01, 0.5, 1.0  # s, of the synthetic record that kernels are called with


@dataclass(frozen=True, repr=False)
class CompileCache(ShortRepr):
    """The folder of compiled functions of this version of the package, and the folders of others beside it."""

    folder: Path | None  # None where nothing can be kept
    functions: int  # compiled functions in it
    size: int  # bytes
    others: tuple[Path, ...] = ()  # folders of other versions of the package or of numba
    other_size: int = 0  # bytes

    def facts(self) -> Iterable[tuple[str, str]]:
        """Where the folder is, what is in it and beside it, as pairs of a name and words."""
        no_folder = cache_doubt() or "none that can be written; set NUMBA_CACHE_DIR"
        yield "folder", no_folder if self.folder is None else str(self.folder)
        yield "compiled", f"{counted(self.functions, 'function')}, {self.size / 1e6:.1f} MB"
        if self.others:
            yield "other versions", f"{counted(len(self.others), 'folder')}, {self.other_size / 1e6:.1f} MB"


def cache(
    *scenes: Scene | str | Path,
    all_models: bool = False,
    clear_others: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> CompileCache:
    """Compile what scenes need, so that their first scan and simulation start at once, and look into the cache.

    Each scene is run with a synthetic record of one and a half seconds and one case of each contact model: the records
    of the scene need not be there.

    Parameters
    ----------
    *scenes : Scene, str or Path
        Scenes, or paths of scene files; without any the cache is only looked into.
    all_models : bool
        Compile every contact model that can collide the buildings of a scene, as `compare` runs them, and not only
        those of the scene.
    clear_others : bool
        Remove the folders of other versions of the package or of numba.
    progress : callable, optional
        Called with the number of scenes done and of all scenes.

    Returns
    -------
    CompileCache
        The folder, the functions in it and their size, after all this.

    Raises
    ------
    PoundingError
        For a scene with faults, and where compiled code cannot be kept.

    Notes
    -----
    Classes from outside the package are compiled by each process.
    """
    studies = [as_scene(scene) for scene in scenes]
    if studies and compile_cache() is None:
        raise PoundingError(
            "cache: compiled code is switched off by NUMBA_DISABLE_JIT; remove it from the environment"
            if INTERPRETED
            else f"cache: {cache_doubt() or 'no folder can be written; set NUMBA_CACHE_DIR to one that can'}"
        )
    for number, study in enumerate(studies, start=1):
        if all_models:
            from pounding_risk.studies.compare import on_equal_terms  # looking into the cache needs no solver

            study = on_equal_terms(study, (), None, (None, None))
        compile_for(study)
        if progress is not None:
            progress(number, len(studies))
    folder = Path(cache_path) if (cache_path := compile_cache()) else None
    entries = sorted(folder.parent.iterdir()) if folder else []
    folders = [other for other in entries if other != folder and other.is_dir() and not other.is_symlink()]
    old_folders = [other for other in folders if VERSION_FOLDER.fullmatch(other.name)]
    if clear_others:
        for other in old_folders:
            shutil.rmtree(other, ignore_errors=True)
        old_folders = [other for other in old_folders if other.exists()]
    files = _code_in(folder) if folder else []
    return CompileCache(
        folder,
        sum(file.suffix == CODE for file in files),
        sum(file.stat().st_size for file in files),
        tuple(old_folders),
        sum(file.stat().st_size for other in old_folders for file in _code_in(other)),
    )


def compile_for(study: Scene) -> None:
    """Run one case of each contact model of a scene under a synthetic record, as `scan` and `simulate` do."""
    from pounding_risk.ensemble.scan import scan
    from pounding_risk.studies.simulate import simulate

    buildings: list[Building | Storeys] = []
    for building in study.buildings:
        support = building.support
        if support.records:  # ground that moves otherwise than its neighbours'
            support = support._replace(factor=0.5 * support.factor, records=())
        if isinstance(building, Building):
            buildings.append(building._replace(support=support))
        else:
            buildings.append(replace(building, support=support))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "made.AT2"
        path.write_text(_made_record(SHAKING + REST + study.lag), encoding="ascii")
        request = RecordRequest(files=(str(path),))
        grid = study.grid
        single = grid._replace(gaps=grid.gaps[:1], yield_forces=grid.yield_forces[:1], amplitudes=(None,))
        small = study.updated(records=request, grid=single, axes=(), buildings=tuple(buildings), text="", overrides=())
        scan(small, check_fraction=1.0, workers=1)
        for name in dict.fromkeys((small.contact_model, *small.grid.contact_models)):
            simulate(small, law=name)


def _made_record(duration: float) -> str:
    """A record as PEER AT2: two periods of a sine, 0.3 g, then rest."""
    count = round(duration / DT) + 1
    times = (number * DT for number in range(count))
    samples = (0.3 * sin(4.0 * pi * time / SHAKING) if time < SHAKING else 0.0 for time in times)
    head = (
        "made to compile with",
        "None, 1/1/2000, made, 0",
        "ACCELERATION TIME SERIES IN UNITS OF G",
        f"NPTS= {count}, DT= {DT} SEC",
    )
    return "\n".join([*head, *map(repr, samples)]) + "\n"


def _code_in(folder: Path) -> list[Path]:
    return [file for file in folder.rglob("*.nb[ci]") if file.is_file()]
