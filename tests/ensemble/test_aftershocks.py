"""Sequences of shocks: a record behind another, in one run, with what has yielded carried over."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scenes import scene_text, storeyed
from sentences import refusal

import pounding_risk as pr
from pounding_risk import assess
from pounding_risk.ensemble.scan import scan
from pounding_risk.motions.record import recording_numbers
from pounding_risk.questions import simulate as simulating
from pounding_risk.results.opened import Results
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene

RECORDS = {"names": ["RSN6-180"], "window": ["0 s", "8 s"], "pga": "0.4 g"}


def text_of(**records) -> str:
    """Two yielding buildings side by side."""
    sides = [storeyed(name, ["100 t"] * 2, stiffness, ["3 m"] * 2, storey_strengths="300 kN")
             for name, stiffness in (("A", "60 MN/m"), ("B", "90 MN/m"))]  # fmt: skip
    return scene_text(*sides, gap="8 mm", effects={"inelastic_storeys": {}}, records=RECORDS | records)


def test_the_sequence_is_both_motions_with_still_ground_between():
    (motion,) = motions_of(parse_scene(text_of(aftershock="RSN753-000", pause="20 s", aftershock_ratio=0.5)))
    first = pr.read_motion("RSN6-180", window=(0.0, 8.0))
    after = pr.read_motion("RSN753-000")
    # The finer step of both; straight lines between samples change no peak.
    step = motion.dt
    assert step == min(first.dt, after.dt)
    begins = 8.0 + 20.0
    times = step * np.arange(motion.acceleration.size)
    known = np.where(times <= 8.0, np.interp(times, first.times, first.acceleration), 0.0)
    scaled = 0.5 * first.pga / after.pga * after.acceleration
    known += np.interp(times - begins, after.times, scaled, left=0.0, right=0.0)
    np.testing.assert_allclose(motion.acceleration, known, atol=1e-12 * first.pga)
    assert motion.duration == pytest.approx(begins + after.duration, abs=step)
    assert motion.pga == pytest.approx(first.pga, rel=1e-12)
    assert any("followed from 28 s on by RSN753-000" in words for words in motion.processing)
    assert motion.record["aftershock"]["name"] == "RSN753-000"


def test_a_plan_names_the_aftershock_its_pause_and_its_size():
    words = [dict(pr.validate(parse_scene(text_of(**RECORDS | {"aftershock": "RSN753-000"} | more))).facts())["records"]
             for more in ({}, {"pause": "20 s", "aftershock_ratio": 0.5})]  # fmt: skip
    assert words[0].endswith("followed after 60 s by RSN753-000 with the factor of each motion")
    assert words[1].endswith("followed after 20 s by RSN753-000 at 0.5 of the PGA of each motion")


def test_without_a_ratio_both_have_one_factor_and_a_stronger_one_is_flagged():
    (motion,) = motions_of(parse_scene(text_of(aftershock="RSN753-000")))
    first, after = pr.read_motion("RSN6-180", window=(0.0, 8.0)), pr.read_motion("RSN753-000")
    assert np.abs(motion.acceleration[-after.acceleration.size :]).max() == pytest.approx(after.pga, rel=1e-12)
    assert any("its aftershock is stronger" in flag for flag in motion.flags) == (after.pga > first.pga)


def test_what_has_yielded_carries_over():
    """A second shock after a long pause: residual drift at its end is that of a run that begins from the first one's.

    With the aftershock nearly zero the residual drift is that of the first motion alone; with a strong one it is not.
    """

    def rest(**records) -> np.ndarray:
        run = pr.simulate(parse_scene(text_of(**records)))
        told = dict(simulating.sheet(run)[0]["rows"])["record"]["text"]
        assert told.endswith(", followed by RSN6-180") == ("aftershock" in records)
        return run["storey_residual_drift"].values

    alone, still = rest(tail="20 s"), rest(aftershock="RSN6-180", pause="20 s", aftershock_ratio=1e-6)
    strong = rest(aftershock="RSN6-180", pause="20 s", aftershock_ratio=2.0)
    assert alone.max() > 1e-3  # m
    np.testing.assert_allclose(still, alone, rtol=1e-4)  # driven by a millionth
    assert np.abs(strong - alone).max() > 1e-3
    study = parse_scene(text_of(aftershock="RSN6-180", pause="20 s", aftershock_ratio=2.0))
    assert parse_scene(study.to_toml()) == study


def test_motions_that_share_a_shock_are_of_one_recording():
    """By a shared aftershock, another component of it, or one that comes first elsewhere; unknown ones by their source.

    A recording whose aftershock is its own repetition, or stands behind it alone, counts by itself.
    """

    def numbers(*shocks: tuple[str, str]) -> list[int]:
        names, aftershock = ([*column] for column in zip(*shocks, strict=True))
        motions = motions_of(parse_scene(text_of(names=names, aftershock=aftershock, pause="1 s")))
        facts = json.loads(json.dumps([motion.record for motion in motions]))  # as a dataset has them
        return recording_numbers(facts, [motion.name for motion in motions]).tolist()

    own = numbers(("RSN6-180", "RSN6-180"), ("RSN753-000", "RSN1690-090"), ("RSN77-164", "RSN6-270"))
    assert own == [0, 1, 0]
    assert numbers(("RSN6-180", "RSN1690-090"), ("RSN753-000", "RSN1690-360"), ("RSN6-270", "RSN77-164")) == [0, 0, 0]
    pulses = [f"ricker: pga=0.2 g, period={period} s, step=0.005 s" for period in (0.5, 0.8)]
    assert numbers(*zip(["RSN6-180", "RSN753-000", "RSN77-164"], [*pulses, pulses[0]], strict=True)) == [0, 1, 0]


@pytest.mark.complete
def test_bounds_count_sequences_that_share_their_aftershock_once():
    """Three recordings, each with an aftershock of its own or all with one, which leaves nothing independent."""
    names = ["RSN6-180", "RSN753-000", "RSN77-164"]
    alone, own, one = (
        scan(parse_scene(text_of(names=names, **more)), check_fraction=0.0)
        for more in ({}, {"aftershock": names, "pause": "1 s"}, {"aftershock": "RSN1690-090", "pause": "1 s"})
    )
    found = [assess(dataset).interfaces[0].verdict for dataset in (alone, own, one)]
    assert [(verdict.motions, verdict.recordings) for verdict in found] == [(3, 3), (3, 3), (3, 1)]
    assert [verdict.independent for verdict in found] == [3.0, 3.0, 1.0]
    assert one["record_recording"].values.tolist() == [0, 0, 0]
    assert any("which count as one" in note for note in Results(one).notes)


def test_what_does_not_go_together_is_refused(says):
    says(refusal(parse_scene, text_of(pause="20 s", aftershock_ratio=0.5)))
    says(refusal(parse_scene, text_of(aftershock="RSN753-000", aftershock_ratio=0.0, pause="2 h")))
    says(refusal(motions_of, parse_scene(text_of(aftershock=["RSN753-000", "RSN6-180"]))))
    own = parse_scene(text_of(aftershock="RSN753-000"), overrides=['building.A.ground_record="RSN753-000"'])
    says(refusal(motions_of, own))
