"""What is published and not among the cases, and why: for the page of `verify` and for the docs."""

from __future__ import annotations

EXPERIMENTS = (
    "Most values are closed forms, or printed or stored by programs. One case is an experiment, the recording of a "
    "bouncing ball: no test of buildings that pound was reached with its parameters and a number."
)
UNREACHED = (
    ("code_aster SDND122 and 123", "they need the search for modes of vibration with impacts"),
    (
        "van Mier et al. (1991), forces; the figures' forces in Jankowski (2005, 2006)",
        "van Mier's findings were read as words alone, and are the property `plateaus`; the forces stand in figures "
        "that were not reached",
    ),
    (
        "Jankowski (2008), peaks of the three-storey pair",
        "the printed peaks were not reached, so that its periods alone are compared (`jankowski_2008`); the paper's "
        "tables of peaks, its record and its yield forces would be needed",
    ),
    (
        "Anagnostopoulos (1988) and Maison and Kasai (1990), amplifications of rows and towers",
        "printed values not reached",
    ),
    (
        "Crozet, Politopoulos, Yang, Martinez and Erlicher (2018), Earthquake Engineering and Structural Dynamics "
        "47(1), 219-235, and a paper of 2019: order of Sobol indices",
        "the text was not reached; the order as it is recalled is not compared",
    ),
    (
        "Muthukumar and DesRoches (2006); Ye, Li and Zhu (2009), table of specified and achieved restitution",
        "abstracts alone were reached; what the published laws return is derived",
    ),
    (
        "restitution of Hertz with damping by Lankarani and Nikravesh, e = 0.8 and less",
        "reached, and ours converged differs by more than 5 %: the formula does not return the specified e",
    ),
    (
        "Chopra, example 16.1, as structdyn solves it: a roof of 58.88 mm at 2 s",
        "reached, and not converged there: its steps of 0.1 s are a tenth of the period; ours at every tolerance and "
        "SciPy's lsim give 70.20 mm",
    ),
    (
        "ETABS verification example 12, pounding of two planar frames",
        "the text was not reached, and it needs a full stiffness matrix for each building",
    ),
    ("separation rules of ASCE 7 and EN 1998-1, worked examples", "none reached that prints all its numbers"),
    (
        "Jeng, Kasai and Maison (1992); Tubaldi, Barbato and Ghazizadeh (2012)",
        "no printed number with all its parameters reached; their relations are the properties `double_difference` "
        "and `first_passage`",
    ),
    (
        "Newton's cradle after Hertz (Hinch and Saint-Jean; Patricio), chains of spheres after Nesterenko",
        "no printed number reached; linear springs and collisions in turn are cases (`herrmann_1981`, `patricio_2004`)",
    ),
    ("Gugan (2000), duration and area of contact of croquet balls", "numbers not reached"),
    (
        "Masroor and Mosqueda (2012, 2013), report MCEER-13-0003: a frame of three storeys on friction pendulums that "
        "strikes moat walls, quarter scale (recordings NEES-2008-0571)",
        "the first page of the report, descriptions and programs that read its recordings, and abstracts of studies "
        "that cite it were reached, with no mass, clearance, stiffness of a wall or force of contact among them; a "
        "public model in OpenSees of isolated frames behind moat walls calls its wall arbitrary",
    ),
)
