"""Every table in CSV has one reader: the same faults, by line, whatever the table holds."""

import doctest
from pathlib import Path

import numpy as np
import pytest
from sentences import refusal

from pounding_risk._common import tables
from pounding_risk._common.counted import counted
from pounding_risk.assessment.gmfs import read_fields
from pounding_risk.assessment.hazard_table import read_hazard
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.table_file import read_table as read_forces
from pounding_risk.motions.manifest import read_manifest, write_manifest
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.sites.event_grid import read_grid
from pounding_risk.motions.target_spectra import read_conditional, read_target
from pounding_risk.streets.table import read_table as read_street

# By the name of the file: its reader, and a sound table.
TABLES = {
    "hazard.csv": (read_hazard, "pga [g],annual rate [1/year]\n0.1,0.01\n0.2,0.001\n"),
    "gmf-data_1.csv": (lambda path: read_fields(f"{path}#0"), "event_id,site_id,gmv_PGA\n0,0,0.1\n1,0,0.2\n"),
    "EventGrid.csv": (read_grid, "GP_file,Longitude,Latitude\nsite0.csv,23.7,38.0\n"),
    "conditional-spectrum-0.csv": (read_conditional, "sa_period,val0,std0\n0.1,0.2,0.5\n1.0,0.1,0.6\n"),
    "target.csv": (read_target, "period [s],Sa [g]\n0.1,0.4\n1.0,0.2\n"),
    "street.csv": (read_street, "name,height [m],storeys\nA,12,4\nB,9,3\n"),
    "forces.csv": (read_forces, "penetration [mm],force [kN]\n0,0\n1,10\n2,20\n"),
    "manifest.csv": (read_manifest, ""),
}


@pytest.fixture(params=TABLES)
def table(request, tmp_path):
    """Path, reader and text of one of the tables."""
    read, text = TABLES[request.param]
    path = Path(tmp_path / request.param)
    if text:
        path.write_text(text)
    else:
        write_manifest([Motion("r", np.ones(3), 0.01, {"source": "x"})], path)
    assert read(path) is not None
    return path, read, path.read_text()


def fault(table, raw):
    path, read, _ = table
    path.write_bytes(raw)
    told = refusal(read, path)
    assert told.startswith(str(path))
    return told


def test_a_row_of_another_length_is_refused_by_its_line(table):
    lines = table[2].splitlines()
    count = len(lines[0].split(","))
    for row, cells in ((f"{lines[1]},1", count + 1), (lines[1].rpartition(",")[0], count - 1)):
        words = fault(table, "\n".join([lines[0], row, *lines[2:]]).encode())
        assert f"line 2: has {counted(cells, 'cell')}, the head has {count}; write one a column" in words


@pytest.mark.parametrize(("mark", "name"), [(";", "semicolons"), ("\t", "tabs")])
def test_columns_that_no_comma_parts_are_refused(table, mark, name):
    if table[0].name == "target.csv":
        pytest.skip("a spectrum may have any of the three marks")
    words = fault(table, table[2].replace(",", mark).encode())
    assert f"line 1: the columns are parted by {name}; write commas between columns" in words


def test_what_is_no_csv_text_or_file_is_refused(table):
    head = table[2].splitlines()[0]
    assert "is not CSV (" in fault(table, f'{head}\n"0.1{"," * head.count(",")}\n'.encode())
    assert "the file is empty; " in fault(table, b"\n \n")
    words = fault(table, head.encode() + b"\n\xff\n")
    assert f"byte {len(head) + 1} is not UTF-8; save the file with that encoding" in words
    table[0].rename(table[0].with_name(f"{table[0].stem}2.csv"))
    told = refusal(table[1], table[0])
    assert "no such file" in told.lower()
    if table[0].name != "target.csv":
        assert told.endswith(f'(did you mean "{table[0].stem}2.csv"?); check the name')


def test_comments_and_blank_lines_are_left_out_and_count(tmp_path):
    faults: list[str] = []
    text = '# one = 1\nname,note\n\nA,"two\nlines"\n#B,\n C , c\n'
    assert tables.csv_rows(text, faults, "") == [
        (2, ["name", "note"]),
        (5, ["A", "two\nlines"]),
        (7, ["C ", "c"]),
    ]
    assert not faults
    (tmp_path / "t.csv").write_text(text)
    read = tables.read_table(tmp_path / "t.csv", error=PoundingError)
    assert read.fact("one") == 1.0 and read.rows[1].cells == ("C", "c")
    with pytest.raises(PoundingError, match=r"line 7: note is .c.; it must be a number: export the file"):
        read.number(read.rows[1], "note")


def test_the_example():
    assert doctest.testmod(tables).failed == 0
