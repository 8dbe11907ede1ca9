"""Every notebook runs from top to bottom, in a copy, with the interpreter of the tests."""

from pathlib import Path

import pytest

# Replacements that reduce the number or length of motions, or of gaps, of a notebook or of the scenes beside it.
FEWER = {
    "accuracy_against_time": [("cases=6, budget=0.5", "cases=2, budget=0.2"), ("num = 31", "num = 7")],
    "city_block": [
        ('["RSN6-180", "RSN77-164", "RSN753-000", "RSN1690-090"]', '["RSN6-180"]'),
        ('["0.15 g", "0.3 g"]}', '["0.3 g"]}, "records": {"window": ["0 s", "8 s"]}'),
    ],
    "contact_law_matters": [
        ('set = "fema-p695-farfield"', 'names = ["RSN6-180", "RSN77-164", "RSN753-000", "RSN1690-090"]'),
        ("DRAWS = 400", "DRAWS = 10"),
    ],
    "contact_law_papers": [
        ('set = "fema-p695-farfield"', 'names = ["RSN6-180", "RSN77-164", "RSN753-000"]'),
        ("DRAWS = 400", "DRAWS = 10"),
        ("[0.3, 0.4, 0.5, 0.65, 0.8, 0.95]", "[0.4, 0.65]"),
    ],
    "code_gaps": [
        ('set = "fema-p695-farfield"', 'names = ["RSN6-180", "RSN77-164", "RSN753-000"]'),
        ("48, 100", "8, 10"),
        ("TS = (0.3, 0.5, 0.8, 1.3, 2.0)", "TS = (0.5, 1.0)"),
    ],
    "comparing_models": [('["RSN6-180", "RSN753-000", "NAPA-HNE"]', '["RSN6-180"]'), ("num = 13", "num = 7")],
    "district": [
        ('"unit": "g"}', '"unit": "g", "window": ["0 s", "8 s"]}'),
        ('{"samples": 64}', '{"samples": 8}'),
        ("for name, text in scenes.items()}", "for name, text in list(scenes.items())[3:5]}"),
        ("['district-row-1']", "['district-row-5']"),
    ],
    "gap_adequacy": [('stop = "120 mm", num = 25', 'stop = "120 mm", num = 7')],
    "gap_not_enough": [
        ("RECORDS = pr.streets.horizontal_records()", "RECORDS = pr.streets.horizontal_records()[:2]"),
        ("NUM = 17", "NUM = 5"),
        ("range(GAP, 131, 10)", "range(GAP, 131, 35)"),
    ],
    "pounding_spectra": [
        ('     "RSN1690-090", "RSN1690-360", "CCC-HN1", "CCC-HN2", "NAPA-HNE", "NAPA-HNN"],', "    ],"),
        ("num=60", "num=12"),
        ("num=21", "num=9"),
        ("num=15", "num=7"),
    ],
    "paper": [("(0.02, 0.05, 0.10)", "(0.02, 0.10)")],
    "rows_study": [
        ("horizontal_records()[:: 2 if QUICK else 1]", "horizontal_records()[:1]"),
        ('pga = "{PGA}"\n', 'pga = "{PGA}"\nwindow = ["0 s", "8 s"]\n'),
        ("CLEAR = [5, 20, 50]", "CLEAR = [5, 20]"),
    ],
    "uncertain_buildings": [("samples = 1024\nseed = 1", "samples = 64\nseed = 1"), ("sobol=256", "sobol=16")],
}
NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.ipynb"))


def test_there_are_notebooks():
    assert NOTEBOOKS


@pytest.mark.complete
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs_and_is_stored_without_results(path: Path, tmp_path: Path):
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs for cell in code), "strip the outputs before committing"
    scenes = {one.name: one.read_text("utf-8") for one in path.parent.glob(f"{path.stem}*.toml")}
    for whole, fewer in FEWER.get(path.stem, []):
        cells = [cell for cell in code if whole in cell.source]
        files = [name for name, text in scenes.items() if whole in text]
        assert len(cells) == 1 or (files and not cells)
        for cell in cells:
            cell.source = cell.source.replace(whole, fewer)
        scenes |= {name: scenes[name].replace(whole, fewer) for name in files}
    for name, text in scenes.items():
        (tmp_path / name).write_text(text, "utf-8")
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    pictures = [out for cell in code for out in cell.outputs if "image/png" in out.get("data", {})]
    assert len(pictures) >= 2
