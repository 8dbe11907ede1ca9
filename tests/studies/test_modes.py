"""`modes`: what is printed and drawn of the buildings' own vibration."""

import numpy as np
import pytest
from figure_words import words_of
from scenes import rigid, scene_text, single, storeyed

import pounding_risk as pr
from pounding_risk.figures.modes import MOST_MODES, modes_figure
from pounding_risk.figures.style import write
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import generated
from pounding_risk.questions.modes import _rows
from pounding_risk.scene.reader import read_scene
from pounding_risk.scene.tables import Effect
from pounding_risk.studies import demo
from pounding_risk.studies.modes import building_modes

SOIL = Effect("soil_flexibility", (("shear_wave_velocity", 150.0), ("radius", 8.0)))
TOWER = generated("a tower of $10", height=30.0, storeys=10, typology="concrete_frame", floor_mass=3e5)


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(demo.scene("paper").to_toml(), encoding="utf-8")
    return path


def test_modes_of_a_scene(scene):
    """The paper's two: their own periods and dampings."""
    found = pr.modes(scene)
    assert [each.name for each in found] == ["frame", "masonry"]
    assert [each.periods.tolist() for each in found] == [pytest.approx([0.208]), pytest.approx([0.007])]
    assert all(each.dampings == pytest.approx([0.05]) and each.shares == pytest.approx([1.0]) for each in found)


ROW = scene_text(
    storeyed("flats", "25 t", "3.46 MN/m", storeys=3, damping_rule="stiffness"),
    rigid(),
    single("shop", "200 t", "0.3 s", height="3 m"),
    name="Three",
    gap="20 mm",
    effects={"p_delta": {}},
)


def test_a_row_of_all_kinds(tmp_path):
    """Jankowski's three storeys with the weight on them; a rigid building has no modes."""
    path = tmp_path / "row.toml"
    path.write_text(ROW, encoding="utf-8")
    flats, wall, shop = pr.modes(path)
    assert flats.periods[0] > 1.2001 and flats.levels.tolist() == [3.0, 6.0, 9.0]
    assert wall.periods.size == 0 and shop.levels.tolist() == [3.0]
    without = pr.modes(read_scene(path).updated(effects=()))[0]
    assert without.periods[0] == pytest.approx(1.2001, abs=6e-5)
    assert without.dampings == pytest.approx(0.05 * without.periods[0] / without.periods, rel=1e-9)


def test_effects_of_the_scene_act():
    study = demo.scene("paper").updated(effects=(SOIL,))
    assert all(each.periods.size == 2 and each.levels[0] == 0.0 for each in pr.modes(study))


def test_rows_end_where_nearly_all_mass_is_carried():
    modes = building_modes(TOWER)
    rows = list(_rows(modes))
    carried = np.cumsum(modes.shares)
    assert carried[len(rows) - 1] >= 0.99 > carried[len(rows) - 2]
    assert rows[0][0] == TOWER.name and [cell["text"] for cell in rows[0][1:3]] == ["1", "0.9949"]  # 0.0466 × 30^0.9
    assert list(_rows(building_modes(Building.rigid("wall")))) == [["wall", "rigid", "–", "–", "–", "–", "–"]]


@pytest.mark.complete
def test_figure(tmp_path):
    """A panel a building, what is drawn is the shapes, and a building on soil moves at the ground."""
    found = [
        building_modes(TOWER),
        building_modes(TOWER, (SOIL,)),
        building_modes(Building("mass", 1e5, 0.3, 0.05)),
        building_modes(Building.rigid("wall")),
        building_modes(Building("tall", 1e5, 0.3, 0.05, height=9.0)),
        building_modes(TOWER),
    ]
    figure = modes_figure(found)
    panels = [axis for axis in figure.axes if axis.get_visible()]
    curves = [[line for line in axis.lines if len(line.get_xdata()) > 2 or line.get_marker() == "o"] for axis in panels]
    assert [len(lines) for lines in curves] == [MOST_MODES, MOST_MODES, 1, 0, 1, MOST_MODES]
    first = curves[0][0]
    assert first.get_xdata() == pytest.approx(np.arange(11) / 10.0) and first.get_ydata()[-1] == pytest.approx(30.0)
    assert curves[1][0].get_xdata()[0] > 0.0 and curves[1][0].get_ydata()[0] == 0.0
    assert curves[4][0].get_ydata().tolist() == [0.0, 9.0]
    assert "rigid" in [text.get_text() for text in panels[3].texts]
    assert words_of(figure).splitlines()[1].startswith("shapes of the 3 slowest modes")
    assert "[1]" in panels[0].get_xlabel()
    assert figure.get_suptitle().startswith("First periods: ")
    assert words_of(modes_figure(found[2:3])).splitlines()[1].startswith("shapes of the only mode")
    one, other = (write(modes_figure(found), tmp_path / f"{name}.svg").read_bytes() for name in "ab")
    assert one == other
