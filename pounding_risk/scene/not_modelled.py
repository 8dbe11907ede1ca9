"""Words that scenes do not take: other names of a key, and subjects that are not modelled, with what to write instead.

`docs/limits.md` says of each subject how good the substitute is. An unknown key of a table is looked up here before
the nearest known key is named.
"""

from __future__ import annotations

from collections.abc import Container

PAGE = "docs/limits.md"
# By the words that people write for each subject; none of them is a key of a scene.
SENTENCES = {
    "period_1 periods t1 fundamental_period mode_shapes frequency frequencies": (
        "T1 is period, beside floor_masses and storey_heights, and storey_stiffnesses too where their ratios are "
        "known; several modes are a table, modes, with period or frequency and the shape of each"
    ),
    "floor_heights floor_levels levels elevations floor_elevations elevation": (
        "levels of floors follow from storey_heights, the height of each storey from the ground up, no elevations"
    ),
    "matrix matrices": ("write stiffness_matrix, with the masses of the floors in floor_masses, or with mass_matrix"),
    "isolators isolator base_isolation isolation_period isolation_stiffness lead_rubber friction_pendulum pendulum lrb "
    "hdr hdrb ndrb fps fpb tcfp tfp dcfp triple_pendulum high_damping_rubber elastomeric_bearing bearing bearings": (
        "isolators are the key isolation of a building with storeys: "
        'isolation = {slab_mass = "600 t", height = "1.5 m", strength = "900 kN", stiffness = "5 MN/m"}, or friction '
        "and radius of pendulums in place of the latter two; pendulums of several radii and rubber that hardens are "
        "bilinear there, one law for each end of the range"
    ),
    "moat moat_gap moat_wall retaining_wall stop backfill": (
        "the wall of a moat is a [[building]] of its own beside the isolated one, rigid = true and as tall as the "
        "slab, or of one storey where it gives; the clearance is the gap of their [[interface]]"
    ),
    # The first three are keys of an [[interface]], which are written in buildings.
    "link_stiffness link_damping link_at link links link_force coupling coupling_stiffness": (
        "links between neighbours are link_stiffness, link_damping and link_at of their [[interface]], with "
        "link_strength, link_slack or link_breaking_force where they slip, are slack or break"
    ),
    "hook hooks restrainer restrainers cable tie friction_damper friction_link": (
        "a hook or restrainer between neighbours is link_stiffness with link_slack of their [[interface]], a friction "
        "damper link_stiffness with link_strength"
    ),
    "bumpers rubber rubber_bumper shock_absorber": (
        "bumpers in a gap are bumper_length of its [[interface]], with their force as contact_model, such as "
        'contact_model = "tabulated" and a table'
    ),
    "damper dampers damper_coefficient damping_coefficient viscous_damper fvd fluid_viscous_damper maxwell "
    "maxwell_damper": (
        "a damper between neighbours is link_damping of their [[interface]], with link_exponent where its force is a "
        "power of the speed and link_brace_stiffness where its brace gives; for one within a building write what it "
        "adds to the first mode into damping"
    ),
    "torsion eccentricity rotation torsional_stiffness torsional_period": (
        "floors that rotate are the key plan of a building with storeys, with eccentricity_along under both "
        "horizontals; beyond elastic ones write the motion of the edge that faces the neighbour, from a model of your "
        "own, as displacement_history"
    ),
    "displacement_histories floor_histories history histories time_history": (
        "the motion of a model of your own is displacement_history of its [[building]]: CSV files with the columns "
        "time [s], floor 1 [mm] and so on, one for each record; velocities and accelerations are no input"
    ),
    "degradation degrading pinching backbone stiffness_degradation storey_law": (
        "storeys that soften, pinch or lose strength are the key hysteresis of a building with storey_strengths, such "
        'as hysteresis = {rule = "peak_oriented", unloading = 0.4, energy_capacity = 60}'
    ),
}
# Names from the literature for a rule of hysteresis, and below for a contact model, with what to write instead.
RULES_ELSEWHERE = {
    "takeda modified_takeda clough modified_clough clough_johnston stiffness_degrading qhyst q_hyst": (
        'reloading towards the largest drift before, as Clough and Takeda have it, is rule = "peak_oriented", with '
        "unloading for the exponent of Takeda's unloading stiffness"
    ),
    "bilinear elastoplastic elastic_plastic epp prager masing ramberg_osgood trilinear steel01": (
        'a backbone of straight lines whose branches double after a turn (Masing) is rule = "kinematic"; '
        "storeys without hysteresis follow it with one line past yield"
    ),
    "ibarra ibarra_medina_krawinkler ibarra_krawinkler imk modified_imk mimk ibarramedinakrawinkler": (
        'rule = "peak_oriented" has the loss of strength by energy of Ibarra, Medina and Krawinkler, with a falling '
        "backbone and energy_capacity; losses of stiffness by energy are not modelled"
    ),
    "pinching pinched pinching4 slip sliplock slip_lock takeda_slip sdegrading strength_degrading degrading": (
        'pinching, and strength lost by energy, are keys of rule = "peak_oriented": pinching_drift, pinching_force '
        "and energy_capacity; slip without any force is not modelled"
    ),
    "pivot origin_oriented flag_shaped self_centering self_centring origin nonlinear_elastic giuffre_menegotto_pinto "
    "menegotto_pinto steel02 fiber fibre": (
        'not modelled; the nearest rule is "peak_oriented", or "kinematic" for steel: compare one cyclic loop'
    ),
    "baber_noori baber_wen bouc_wen_baber_noori bw boucwen wen": 'the smooth rule is "bouc_wen"; it does not pinch',
}
LAWS_ELSEWHERE = {
    "kelvin kelvinvoigt kv linear_viscoelastic spring_dashpot anagnostopoulos": (
        'a spring and a dashpot side by side are "kelvin_voigt", which pulls before it parts, or '
        '"kelvin_voigt_tension_cut", which does not'
    ),
    "nonlinear_viscoelastic jankowski_2005 jankowski2005 jankowski_2006 jankowski2006": (
        'the nonlinear viscoelastic model of Jankowski (2005) is "jankowski"'
    ),
    "hertzdamp hertz_damped hunt_crossley huntcrossley muthukumar muthukumar_desroches": (
        'a Hertz spring with damping by the penetration is "hertz_damp", or "hertz_damp_exact" with the e asked for'
    ),
    "lankarani_nikravesh lankarani nikravesh flores": (
        'the law of Lankarani and Nikravesh has the formula of "hertz_damp", d = 0.75 (1 − e²)'
    ),
    "impactmaterial impact_material impact bilinear_impact": 'ImpactMaterial of OpenSees has the form of "bilinear"',
    "stereo stereo_mechanical coefficient_of_restitution newton rigid_impact": (
        'velocities that jump by the coefficient of restitution are "stereomechanical"'
    ),
    "mahmoud mahmoud_jankowski modified_kelvin linear_viscoelastic_modified": (
        'the modified linear viscoelastic model of Mahmoud and Jankowski (2011) is "modified_kelvin_voigt"'
    ),
    "elastic gap gap_element elasticgap spring penalty elasticppgap": 'an elastic gap element is "linear"',
    "elastoplastic elastic_plastic plastic": (
        'a contact that yields is "van_mier" or "viscous_elastoplastic", with a yield_force'
    ),
    "rubber rubber_bumper bumper polymer": 'bumpers are bumper_length and contact_model = "tabulated" with a table',
}
# Names that papers and other programs have for a key.
NAMES_ELSEWHERE = {
    "gap": "distance clearance separation spacing seismic_gap initial_gap joint_width",
    "contact_model": "model law contact_law impact_model impact_law",
    "stiffness": "k beta contact_stiffness impact_stiffness",
    "restitution": "e cor coefficient_of_restitution restitution_coefficient",
    "yield_force": "f_e fe f_y fy yield_strength",
    "damping": "xi zeta damping_ratio damping_ratios",
    "mass": "m weight",
    "floor_masses": "masses weights storey_masses story_masses floor_weights lumped_masses",
    "floor_mass": "storey_mass story_mass floor_weight mass_per_floor",
    "storey_stiffnesses": "stiffnesses storey_stiffness story_stiffness story_stiffnesses interstorey_stiffness",
    "storey_heights": "heights storey_height story_height story_heights",
    "storey_strengths": "strengths storey_strength storey_shears yield_shears yield_forces yield_strengths",
    "storeys": "stories floors n_storeys n_stories number_of_storeys number_of_stories number_of_floors",
    "names": "record records name id ids",
    "files": "file path paths",
}
BY_WORD = {word: sentence for words, sentence in SENTENCES.items() for word in words.split()}


def instead_of(key: str) -> str:
    """What to write in place of a key whose subject is not modelled; "" for any other key."""
    sentence = BY_WORD.get(key.lower())
    return f"{sentence} ({PAGE})" if sentence else ""


def key_meant(name: str, keys: Container[str]) -> str:
    """The key, one of these, of which ``name`` is another name; "" where it is none of any."""
    return next((key for key, names in NAMES_ELSEWHERE.items() if key in keys and name.lower() in names.split()), "")
