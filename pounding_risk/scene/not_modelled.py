"""Words that scenes do not take because the model has not what they mean, each with what to write instead.

`docs/limits.md` says of each how good the substitute is. A key that is none of a table is looked up here before the
nearest known key is named.
"""

from __future__ import annotations

PAGE = "docs/limits.md"
MODES = (
    "modes follow from masses and stiffnesses: write the first period beside floor_masses and storey_heights, and "
    "storey_stiffnesses too where their ratios are known"
)
MATRICES = (
    "a building is a chain of floors on storey springs and has no matrices; write floor_masses and storey_stiffnesses, "
    "each the shear of a storey over its drift in the first mode"
)
ISOLATION = (
    "isolators are the key isolation of a building with storeys: "
    'isolation = {slab_mass = "600 t", height = "1.5 m", strength = "900 kN", stiffness = "5 MN/m"}'
)
LINKS = "nothing joins buildings but contact, which only pushes; leave the link out"
DAMPERS = "there are no dampers; write what they add to the first mode into damping"
TORSION = "buildings move along the row and do not rotate; take the gap between their edges from a model of your own"
HISTORIES = (
    "histories are results and no input; for a model of your own the gap that it needs is the largest of u_left − "
    "u_right"
)
DEGRADING = (
    "storeys keep stiffness and strength, bilinear by storey_strengths and [effects] inelastic_storeys; run the scene "
    "once more with the stiffness that is left"
)

# By what people write for each subject; none of it is a key of a scene.
SENTENCES: dict[tuple[str, ...], str] = {
    ("period_1", "periods", "t1", "fundamental_period", "modes", "mode_shapes", "frequency", "frequencies"): MODES,
    ("mass_matrix", "stiffness_matrix", "damping_matrix", "matrix", "matrices"): MATRICES,
    ("isolators", "isolator", "base_isolation", "isolation_period", "isolation_stiffness"): ISOLATION,
    ("link", "links", "link_stiffness", "link_force", "coupling", "coupling_stiffness"): LINKS,
    ("damper", "dampers", "link_damping", "damper_coefficient", "damping_coefficient", "viscous_damper"): DAMPERS,
    ("torsion", "eccentricity", "rotation", "torsional_stiffness", "torsional_period"): TORSION,
    ("displacement_history", "displacement_histories", "history", "histories", "time_history"): HISTORIES,
    ("degradation", "degrading", "pinching", "hysteresis", "backbone", "stiffness_degradation"): DEGRADING,
}
BY_WORD = {word: sentence for words, sentence in SENTENCES.items() for word in words}


def instead_of(key: str) -> str:
    """What to write in place of a key whose subject is not modelled; "" for any other key."""
    sentence = BY_WORD.get(key.lower())
    return f"{sentence} ({PAGE})" if sentence else ""
