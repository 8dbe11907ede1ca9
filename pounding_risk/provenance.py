"""What it takes to reproduce a dataset beside its scene and records: what was asked, and digests of what was used."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import sha256

import numpy as np

from pounding_risk._jit import source_digest
from pounding_risk.motions import Motion
from pounding_risk.results import as_text
from pounding_risk.study import Study


def provenance(study: Study, motions: Iterable[Motion], screening: bool, check_fraction: float) -> dict[str, str]:
    """Attributes of a dataset: scene file, digest of the resolved scene, options, digests of motions and kernels.

    Together with ``scene_resolved``, ``records`` and ``versions`` they are what `reruns.rerun` goes by.
    """
    return {
        "scene_file": study.source.encode(errors="backslashreplace").decode(),  # a name need not be text
        "scene_sha256": text_digest(study.to_toml()),
        "options": as_text({"screening": screening, "check_fraction": check_fraction}),
        "motions_sha256": as_text({motion.name: digest_of(motion) for motion in motions}),
        "kernels_digest": source_digest(),
    }


def text_digest(text: str) -> str:
    """sha256 of a text in UTF-8."""
    return sha256(text.encode()).hexdigest()


def digest_of(motion: Motion) -> str:
    """sha256 of a motion as the runs see it: every sample [m/s²] and then the time between them [s], as 8 bytes each.

    Least significant byte first, whatever the machine.
    """
    values = np.append(motion.acceleration, motion.dt).astype("<f8")
    return sha256(values.tobytes()).hexdigest()
