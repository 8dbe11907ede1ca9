"""Time of a scan along axes of a scene's numbers over that of a loop of ``--set``: ``python benchmarks/scene_axes.py``.

Eight periods, five masses and five coefficients of restitution of a pair under one record: 200 scenes. In one process
the scan and the loop of `scan` take turns; on the command line a command for each scene is timed on some of them.
Printed are medians in processor seconds, their ratio, and whether the results are equal bit for bit.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import process_time

from shortened import either

import pounding_risk as pr
from pounding_risk.results.scene_axes import at_one_place, selected
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.variants import Variants

SCENE = """
[[building]]
name = "left"
mass = "500 t"
period = "0.5 s"

[[building]]
name = "right"
mass = "800 t"
period = "1.0 s"

[[interface]]
gap = "40 mm"
contact_model = "jankowski"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65

[records]
names = ["RSN6-180"]

[grid]
gap = GAPS
"building.left.period" = {start = "0.3 s", stop = "0.7 s", num = PERIODS}
"building.left.mass" = {start = "400 t", stop = "600 t", num = MASSES}
"interface.restitution" = RESTITUTIONS
""".replace("PERIODS", either("8", "2")).replace("MASSES", either("5", "2"))
SCENE = SCENE.replace("RESTITUTIONS", either("[0.5, 0.6, 0.7, 0.8, 0.9]", "[0.5, 0.6]"))
GAPS = {
    "most cases touch": '["0 mm", "10 mm", "20 mm", "30 mm"]',
    "few cases touch": '["100 mm", "130 mm", "160 mm", "190 mm"]',
}
COMMANDS = either(5, 1)  # scenes of the loop on the command line that are timed


def scanned(text: str, overrides: tuple[str, ...] = ()) -> tuple[float, object]:
    """Processor seconds of reading and scanning a scene, and its dataset."""
    begun = process_time()
    dataset = pr.scan(parse_scene(text, overrides=overrides), workers=1)
    return process_time() - begun, dataset


def in_one_process(text: str, repetitions: int) -> tuple[float, float, bool]:
    """Median seconds of the scan along axes and of the loop, in turns, and whether the results are equal."""
    variants = Variants(parse_scene(text))
    scanned(text)
    whole, loops = [], []
    for _ in range(repetitions):
        seconds, dataset = scanned(text)
        whole.append(seconds)
        alone = [scanned(text, variants.overrides(number)) for number in range(variants.count)]
        loops.append(sum(seconds for seconds, _ in alone))
    equal = all(
        at_one_place(selected(dataset, variants.overrides(number))).drop_attrs().equals(one.drop_attrs())
        for number, (_, one) in enumerate(alone)
    )
    return median(whole), median(loops), equal


def commanded(scene: Path, *words: str) -> float:
    """Processor seconds of a command that scans a scene into a file."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "pounding_risk", "scan", str(scene), "--workers", "1", "--new", *words]
    subprocess.run([*command, "-o", str(scene.with_suffix(".nc"))], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def on_the_command_line(text: str, repetitions: int) -> tuple[float, float]:
    """Median seconds of the command along axes, and of a command for each scene."""
    variants = Variants(parse_scene(text))
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(text, encoding="utf-8")
        commanded(scene)
        whole, alone = [], []
        for turn in range(max(repetitions, COMMANDS)):
            if turn < repetitions:
                whole.append(commanded(scene))
            values = variants.overrides(turn * (variants.count - 1) // max(COMMANDS - 1, 1) % variants.count)
            alone.append(commanded(scene, *(word for value in values for word in ("--set", value))))
    return median(whole), variants.count * median(alone)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=either(3, 1))
    repetitions = parser.parse_args().repetitions
    for words, gaps in list(GAPS.items())[: either(2, 1)]:
        text = SCENE.replace("GAPS", gaps)
        whole, loop, equal = in_one_process(text, repetitions)
        print(f"{words}: one process {whole:.2f} s, loop {loop:.2f} s, ratio {whole / loop:.3f}, equal {equal}")
        whole, loop = on_the_command_line(text, repetitions)
        print(f"{words}: one command {whole:.2f} s, a command a scene {loop:.0f} s, ratio {whole / loop:.4f}")


if __name__ == "__main__":
    main()
