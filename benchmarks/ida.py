"""Incremental dynamic analysis of two five-storey frames under 44 records: ``python benchmarks/ida.py [--folder F]``.

The FEMA P-695 far-field set at 20 levels of Sa(0.5 s), through the public `scan` on two threads and the public
`damage`: fragilities of four damage states with pounding and without. Beside them stand fits that share no line with
the package: capacities by NumPy's interpolation, fitted by SciPy's `lognorm.fit` of censored data, and stripes by
SciPy's minimiser. Kernels are compiled before. ``--levels`` takes fewer, ``--records`` some of the catalogue instead.
"""

from __future__ import annotations

import argparse
import time
import tomllib
from pathlib import Path

import numpy as np
import xarray as xr
from scipy import stats
from scipy.optimize import minimize
from shortened import either

import pounding_risk as pr

SET, COMPONENTS, LEVELS, THREADS = "fema-p695-farfield", 44, 20, 2
PERIOD, RANGE = "0.5 s", (0.1, 2.0)  # of Sa, and its lowest and highest level [g]
SHIPPED = ["RSN6-180", "RSN77-164", "RSN753-000", "RSN1690-090", "CCC-HN1", "NAPA-HNE"]
SCENE = """
[scene]
name = "Two five-storey frames"

[[building]]
name = "frame"
storeys = 5
floor_masses = "200 t"
storey_stiffnesses = "271 MN/m"
storey_heights = "3.2 m"
storey_strengths = ["1500 kN", "1400 kN", "1200 kN", "900 kN", "550 kN"]

[[building]]
name = "stiff"
storeys = 5
floor_masses = "200 t"
storey_stiffnesses = "796 MN/m"
storey_heights = "3.2 m"
storey_strengths = ["3000 kN", "2800 kN", "2400 kN", "1800 kN", "1100 kN"]

[[interface]]
gap = "20 mm"
contact_model = "jankowski"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65

[effects]
inelastic_storeys = {}

[[damage]]
name = "slight"
building = "frame"
drift = "0.5 %"

[[damage]]
name = "moderate"
building = "frame"
drift = "1 %"

[[damage]]
name = "extensive"
building = "frame"
drift = "2 %"

[[damage]]
name = "contents"
building = "frame"
acceleration = "0.8 g"

[records]
"""


def scene(records: int, levels: int) -> pr.Scene:
    """The two frames under the first records of the set."""
    tables = tomllib.loads(SCENE)
    values = [f"{value:.6g} g" for value in np.linspace(*RANGE, levels)]
    levels_of_sa = {"measure": "sa", "period": PERIOD, "levels": values}
    names = {"set": SET} if records == COMPONENTS else {"names": SHIPPED[:records]}
    tables["records"] = {**names, "intensity": levels_of_sa}
    return pr.read_scene(tables)


def capacities_by_numpy(results: xr.Dataset, state: str, side: str) -> stats.CensoredData:
    """First crossings by `np.interp`, and the motions beyond the levels."""
    one = results.sel(state=state, pounding=side).squeeze("polarity")
    known, below, above = [], [], []
    for im, demand in zip(one["motion_intensity"].values, one["demand_ratio"].values, strict=True):
        above_one = np.flatnonzero(demand >= 1.0)
        if not above_one.size:
            above.append(im[-1])
        elif above_one[0] == 0:
            below.append(im[0])
        else:
            pair = [above_one[0] - 1, above_one[0]]
            known.append(np.interp(1.0, demand[pair], im[pair]))
    return stats.CensoredData(uncensored=known, left=below, right=above)


def fit_by_scipy(results: xr.Dataset, state: str, side: str, method: str) -> tuple[float, float]:
    """Median and dispersion by code that is not the package's."""
    if method == "ida":
        dispersion, _, median = stats.lognorm.fit(capacities_by_numpy(results, state, side), floc=0.0)
        return float(median), float(dispersion)
    one = results.sel(state=state, pounding=side)
    reached, runs, level = one["reached"].values, one["runs"].values, results["level"].values

    def lost(point: np.ndarray) -> float:
        return -float(stats.binom.logpmf(reached, runs, stats.norm.cdf(np.log(level / point[0]) / point[1])).sum())

    start = [float(one["median"]) * 1.2, float(one["dispersion"]) * 1.2]
    best = minimize(lost, start, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-11}).x
    return float(best[0]), float(best[1])


def print_curves(results: xr.Dataset) -> None:
    """A row for each curve, beside SciPy's fit of the same runs."""
    method = results.attrs["method"]
    print(
        f"\n| state | pounding | reached in | median [g] | dispersion | SciPy's median, dispersion ({method}) | ratio |"
    )
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |")
    for state in map(str, results["state"].values):
        for side in ("with", "without"):
            one = results.sel(state=state, pounding=side)
            median, dispersion = float(one["median"]), float(one["dispersion"])
            other = fit_by_scipy(results, state, side, method) if np.isfinite(median) else (np.nan, np.nan)
            ratio = ""
            if side == "with":
                low, high = (float(one[f"median_ratio_{end}"]) for end in ("low", "high"))
                ratio = f"{float(one['median_ratio']):.3f} ({low:.3f} to {high:.3f})"
            counts = f"{int(one['reached'].sum())} of {int(one['runs'].sum())}"
            print(
                f"| {state} | {side} | {counts} | {median / 9.80665:.4f} "
                f"| {dispersion:.4f} | {other[0] / 9.80665:.4f}, {other[1]:.4f} | {ratio} |"
            )


def main() -> int:
    """Scan, fit by both methods, compare with SciPy, and write files where a folder is given."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, help="where to write the datasets and figures")
    parser.add_argument("--levels", type=int, default=either(LEVELS, 4))
    parser.add_argument("--records", type=int, default=either(COMPONENTS, 2), help="fewer are records of the catalogue")
    options = parser.parse_args()
    if options.folder is not None:
        options.folder.mkdir(parents=True, exist_ok=True)
    study = scene(options.records, options.levels)
    warm = scene(1, 2)
    pr.scan(warm.replace('records.window=["0 s", "0.5 s"]'), check_fraction=0.0)
    wall, cpu = time.perf_counter(), time.process_time()
    target = None if options.folder is None else options.folder / "ida_scan.nc"
    scanned = pr.scan(study, target, check_fraction=0.0, workers=THREADS, new=True)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(f"scan of {scanned['status'].size} cases: {wall:.1f} s, {cpu:.1f} s of processor time")
    for method in ("ida", "stripes"):
        start = time.process_time()
        results = pr.damage(scanned, method=method)
        print(f"\n{method}: {time.process_time() - start:.2f} s of processor time. {results.attrs['finding']}")
        print_curves(results)
        if options.folder is not None:
            pr.save(results, options.folder / f"{method}.nc")
            pr.figures.write(pr.figures.damage_figure(results), options.folder / f"{method}.png")
    if options.folder is not None:
        pr.figures.write(pr.figures.ida_figure(pr.damage(scanned, method="ida")), options.folder / "ida_demands.png")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
