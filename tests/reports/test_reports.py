"""Reports: every number is the dataset's, in the page and in the PDF; pages stand alone, and are the same on any day.

The datasets are made, not solved (`benchmarks/made_scan.py`): what is checked is what a report says of its dataset.
"""

import hashlib
import json
import os
import re
import sys
import unicodedata
from functools import cache
from html import unescape
from importlib import import_module
from io import BytesIO
from pathlib import Path

import commands
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from lxml.html import document_fromstring
from made_scan import made_scan
from matplotlib.patches import StepPatch
from processes import output
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.figures.assess import draw_contact
from pounding_risk.figures.style import panel
from pounding_risk.render.sheet import KEPT, LONG, number
from pounding_risk.reports import document as model
from pounding_risk.reports import html as page
from pounding_risk.reports import pdf as document
from pounding_risk.reports import sections
from pounding_risk.reports.data import ReportData, companions
from pounding_risk.reports.sections import answers, provenance
from pounding_risk.results.files import save
from pounding_risk.results.scene_axes import with_axes
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.units import SHOWN, rounded

G = 9.80665
SIZE = {"m": 1e3, "N": 1e-3, "%": 1e2, "m/s2": 1.0 / 9.80665, "kg": 1e-3}  # by hand, beside SHOWN
STRANGE = 'A <b>pair</b> & "co." #panic("x") $ \\ `code` 1*2_3_'


@pytest.fixture(scope="module")
def scan() -> xr.Dataset:
    """Twenty-six gaps, so that the table of contact is a long one, and five failed runs."""
    return made_scan(7, np.linspace(0.0, 0.1, 26), (2e5, 5e5, np.inf), 3, failed=5)


@pytest.fixture(scope="module")
def results(scan, tmp_path_factory) -> Path:
    """The dataset on disk."""
    return save(scan, tmp_path_factory.mktemp("results") / "results.nc")


@pytest.fixture(scope="module")
def built(scan, results) -> model.Document:
    checksum = hashlib.sha256(results.read_bytes()).hexdigest()
    return model.build(ReportData(with_axes(scan), assess(scan), {}, checksum))


@pytest.fixture(scope="module")
def pdf(results) -> Path:
    """The PDF of the dataset on disk, as a user has it written."""
    pytest.importorskip("typst")
    return pr.report(results, results.with_name("report.pdf"))


class Page:
    """A page: its elements, and its tables as rows of (words, values)."""

    def __init__(self, text: str):
        self.root = document_fromstring(text)
        self.tags = [element.tag for element in self.root.iter()]
        self.ids, self.alts = self.root.xpath("//@id"), self.root.xpath("//*[@role='img']/@aria-label")
        places = ("href", "xlink:href", "src", "action")
        self.places = [element.get(key) for element in self.root.iter() for key in places if key in element.attrib]

    def table(self, words: str) -> list[list[tuple[str, list[str]]]]:
        """The last table whose caption has these words: the whole one, where the text has only some rows."""
        caption = [each for each in self.root.iter("caption") if words in each.text_content()][-1]
        rows = caption.getparent().iterfind("tbody/tr")
        return [[(cell.text_content(), " ".join(cell.xpath(".//data/@value")).split()) for cell in row] for row in rows]


@pytest.fixture(scope="module")
def html(built) -> str:
    return page.page(built)


@pytest.fixture(scope="module")
def read(html) -> Page:
    return Page(html)


def column(rows, place: int) -> list[float]:
    return [float(row[place][1][0]) for row in rows]


@given(st.floats(-1e300, 1e300), st.integers(2, 6))
def test_a_number_is_rounded_to_half_a_unit_of_its_last_digit(value, digits):
    """What is shown is within half a unit of the digits asked for, and reads as a number without padding."""
    text = rounded(value, digits)
    assert not re.search(r"e[+]|e-?0", text)
    unit = 10.0 ** (np.floor(np.log10(abs(value))) - digits + 1) if value and abs(value) > 1e-300 else 1e-300
    assert abs(float(text) - value) <= 0.5000001 * unit


@pytest.mark.parametrize("unit", SIZE)
def test_units_are_those_of_engineers(unit):
    """The table of units against one written by hand."""
    assert SHOWN[unit][1] == SIZE[unit]
    assert float(number(3.0, unit)["text"]) == pytest.approx(3.0 * SIZE[unit], rel=5e-4)


def test_what_is_not_there_is_a_dash():
    assert [rounded(value) for value in (np.nan, np.inf, -np.inf, -0.0)] == ["–", "∞", "-∞", "0"]
    assert number(np.nan)["raw"] is None


def test_the_table_of_contact_is_the_datasets(scan, read):
    """Counts, runs and probabilities at every gap, straight from the gap that each motion needs."""
    rows = read.table("motions with contact against the gap")
    needed = scan["peak_closing_free"].values.ravel()
    gaps = scan["gap"].values
    assert column(rows, 0) == pytest.approx(gaps, abs=0.0)
    counts = [(needed > gap).sum() for gap in gaps]
    assert column(rows, 1) == counts
    assert column(rows, 2) == [needed.size] * gaps.size
    assert column(rows, 3) == pytest.approx(np.array(counts) / needed.size, rel=1e-15)


def test_the_table_of_yielding_is_the_datasets(scan, read):
    """At the scene's gap, by model and F_E; failed runs are counted in no column."""
    here = scan["yield_exceedance"].sel(gap=0.04)
    rows = read.table("probability of reaching")
    assert len(rows) == 3 * 2
    for row in rows:
        law, force = row[0][0].replace(" ", "_"), float(row[1][1][0])
        values = here.sel(contact_model=law, yield_force=force).values
        assert float(row[2][1][0]) == (values == 1).sum()
        assert float(row[3][1][0]) == (values >= 0).sum()


def test_the_table_of_records_is_the_datasets(scan, read):
    rows = read.table("Records. PGA")
    assert [row[0][0] for row in rows] == list(scan["record"].values)
    assert column(rows, 7) == list(scan["record_pga"].values)
    assert np.array([column(rows, 8), column(rows, 9)]).T.tolist() == scan["peak_closing_free"].values[..., 0].tolist()


@pytest.mark.complete
def test_the_table_of_records_names_their_aftershocks(scan):
    """A dataset of sequences has a column of them, whose caption says of which shock the other facts are."""
    entries = json.loads(scan.attrs["records"])
    entries[0]["aftershock"] = {"name": "RSN753-000", "source": "RSN753-000", "sha256": "", "station": "Corralitos"}
    shown = Page(page.page(model.build(ReportData(scan.assign_attrs(records=json.dumps(entries)), assess(scan), {}))))
    names = [cells[1][0] for cells in shown.table("Records. PGA")]
    assert names == ["RSN753-000", *["–"] * (scan.sizes["record"] - 1)]
    assert "station and as found are those of the record before its aftershock" in shown.root.text_content()


@pytest.mark.complete
def test_records_are_shown_as_the_buildings_felt_them(scan):
    """At the amplitude that is assessed; an older dataset, which does not tell it, shows them as before."""
    count = scan.sizes["record"]
    level = 0.4 * G
    felt = scan.expand_dims(pga=[0.2 * G, level], axis=2).assign_coords(
        record_pga_felt=(("record", "pga"), np.tile([0.2 * G, level], (count, 1))),
        record_scale_factor=(("record", "pga"), np.tile([1.5, 3.0], (count, 1))),
    )
    flat = ("record_spectral_acceleration",)
    felt = felt.assign({name: scan[name] for name in flat})
    shown = Page(page.page(model.build(ReportData(with_axes(felt), assess(felt), {}))))
    rows = shown.table(
        "Records. PGA is that of the motions as the buildings felt them, scaled to a PGA of 0.4 g; factor"
    )
    assert column(rows, 7) == [3.0] * count and column(rows, 8) == [level] * count
    # Sa of the record at the left building's period, in g, times the factor from its own PGA to the grid's.
    periods = scan["period"].values
    at = int(np.abs(np.log(periods / 0.5)).argmin())
    told = np.median(scan[flat[0]].values[:, at] * level / scan["record_pga"].values) / G
    (words,) = (alt for alt in shown.alts if alt.startswith("Spectral acceleration against period"))
    assert float(re.search(r"median is (\S+) g at 0.5 s", words)[1]) == pytest.approx(told, rel=5e-4)  # four digits
    old = Page(page.page(model.build(ReportData(with_axes(scan), assess(scan), {}))))
    assert old.table("Records. PGA is that of the records before the grid's amplitude; a smaller gap")


def test_contact_models_are_the_datasets(scan, read):
    """Median and middle 68 % of the motions with contact, at the scene's gap and its own F_E, which never yields."""
    here = scan.sel(gap=0.04, yield_force=np.inf)
    for row in read.table("outputs by contact model"):
        one = here.sel(contact_model=row[0][0].replace(" ", "_"))
        touching = one["impact_count"].values > 0
        force = one["peak_contact_force"].values[touching]
        assert column([row], 2) == [touching.sum()]
        expected = np.percentile(force, (50.0, 16.0, 84.0))
        assert [float(value) for value in row[5][1]] == pytest.approx(expected, rel=1e-15)


def test_what_contact_does_to_a_building_is_the_datasets(scan, read):
    """Over the motions with contact at the scene's gap, each over its own twin without contact."""
    here = scan.sel(gap=0.04, yield_force=np.inf, contact_model="jankowski")
    touching = here["impact_count"].values[..., 0] > 0
    for row in read.table("peaks of the buildings"):
        with_contact = here["peak_displacement"].sel(building=row[0][0]).values[touching]
        free = scan["peak_displacement_free"].sel(building=row[0][0]).values[touching]
        expected = np.percentile(with_contact / free, (50.0, 16.0, 84.0))
        assert [float(value) for value in row[4][1]] == pytest.approx(expected, rel=1e-14)
        assert column([row], 5) == [(with_contact > free).sum()]
        assert column([row], 6) == [touching.sum()]


def test_the_accuracy_statement_is_the_datasets(scan, read):
    told = {row[0][0]: row[1][1] for row in read.table("Tolerance, recomputed runs")}
    assert float(told["cases"][0]) == scan["status"].size
    assert float(told["with a run of their own"][0]) == int(scan["simulated"].sum())
    assert float(told["recomputed at a tighter tolerance"][0]) == int((scan["sensitive"] >= 0).sum())
    largest = float(np.nanmax(scan["change_peak_contact_force"].values))
    assert float(told["peak contact force moved by, largest"][0]) == largest
    assert float(told["failed: too many contacts"][0]) == 5
    own = (scan["impact_count"] > 0) & (scan["simulated"] == 1)
    assert float(told["the same, largest"][0]) == float(scan["energy_residual"].where(own).max())


def test_what_codes_ask_is_that_of_the_rules(scan, html, read):
    """Each rule's median, and the motions in which it falls short; the unverified say so."""
    for words in (
        "own peaks; not the code",
        "smaller separations and setbacks are allowed where rational analyses",
        "IS 1893 (Part 1):2025 was withdrawn on 3 March 2026",
    ):
        assert words in " ".join(html.split())
    found = code_table(scan)
    rows = read.table("separations that rules require")
    for row, each in zip(rows, found.rules, strict=True):
        assert row[2][0] == each.row.verification
        assert each.row.superseded in row[-1][0]
        if each.exceeded is not None:
            assert column([row], 3) == [each.middle]
            assert row[6][0] == f"{round(each.exceeded * found.motions)} of {found.motions}"


def test_the_summary_is_the_assessment(scan, html, read):
    verdict = assess(scan).interfaces[0].verdict
    plain = re.sub(r"<[^>]*>", "", html)
    assert verdict.sentence in plain
    assert verdict.word in plain
    told = {row[0][0]: row[1] for row in read.table("the numbers behind the verdict")}
    needed = np.percentile(scan["peak_closing_free"].values, 84.0, method="inverted_cdf")
    assert told["gap that 84 % of the motions need"][0] == f"{1e3 * rounded_up(needed):.4g} mm"
    assert f"{5} of {scan['status'].size} cases failed" in plain


def test_the_conclusion_comes_first(scan, html):
    """What to provide stands before what was seen, in the box of the verdict."""
    in_order(scan, squeezed(unescape(re.sub(r"<[^>]*>", "", html))))
    verdict = assess(scan).interfaces[0].verdict
    closing = np.sort(np.array(assess(scan).interfaces[0].closing))[::-1]
    # 16 % of the motions, whole ones, may close it: the next one is what it has to hold, rounded up to three digits.
    needed = closing[int(0.16 * closing.size)]
    provided = float(re.search(r"([0-9.]+) mm", verdict.conclusion[1])[1]) / 1e3
    assert needed <= provided * (1.0 + 1e-9) and provided <= 1.01 * needed  # three digits: 1 % at most


def in_order(scan, text: str) -> None:
    """The sentences of the verdict stand in a text one after the other."""
    verdict = assess(scan).interfaces[0].verdict
    places = [text.index(squeezed(each)) for each in (*verdict.conclusion, verdict.sentence, *verdict.evidence)]
    assert places == sorted(places)


SIGNED = {"project": "Quay <12> & $co.$", "author": "A. B. Señor", "revision": "B", "date": "2 May 2026"}


@pytest.mark.complete
def test_a_report_is_signed_as_its_author_says(results, tmp_path):
    told = pr.report(results, tmp_path / "signed.html", **SIGNED).read_text(encoding="utf-8")
    head = re.search(r"<header>.*?</header>", told, re.DOTALL)[0]
    assert re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", head) == [
        ("Project", "Quay &lt;12&gt; &amp; $co.$"), ("Author", "A. B. Señor"), ("Revision", "B"), ("Date", "2 May 2026")
    ]  # fmt: skip
    assert '<meta name="author" content="A. B. Señor">' in told
    assert "--date &#39;2 May 2026&#39;" in told  # the command that makes the same report
    reader = pytest.importorskip("pypdf").PdfReader(pr.report(results, tmp_path / "signed.pdf", **SIGNED))
    first = squeezed(reader.pages[0].extract_text())
    assert all(squeezed(words) in first for words in SIGNED.values())
    assert reader.metadata.author == SIGNED["author"]


def test_what_is_not_signed_is_not_there(html):
    """No date is made up, and no empty line stands for a name."""
    assert "<dl>" not in html and 'name="author"' not in html


def test_the_model_is_json(built):
    """Without NaN or infinity, which JSON has not."""
    assert json.loads(json.dumps(built, allow_nan=False)) == built


def test_the_probability_of_contact_is_drawn_once_as_its_steps(scan, built):
    """Steps at what each motion closes, counted by hand; target, required gap and the gap judged stand in it."""
    names = [block["name"] for part in built["sections"] for block in part["blocks"] if block["kind"] == "figure"]
    assert [name for name in names if name.endswith(("-contact", "-required"))] == ["interface-1-contact"]
    closing = np.sort(scan["peak_closing_free"].values.ravel())
    assessment = assess(scan, gap=0.02, percentile=90.0, target=0.1)
    (axis,) = panel(draw_contact, assessment, assessment.interfaces[0]).axes
    (drawn,) = (patch for patch in axis.patches if isinstance(patch, StepPatch))
    values, edges, _ = drawn.get_data()
    for gap in np.linspace(0.0, closing[-1] * 1.1, 997):
        place = np.searchsorted(edges, 1e3 * gap, "right") - 1
        assert values[place] == pytest.approx(np.mean(closing > gap))
    lines = {line.get_label(): line for line in axis.get_lines()}
    required = float(np.percentile(closing, 90.0, method="inverted_cdf"))
    words = f"required by 90 %: {1e3 * rounded_up(required):.3g} mm (bar: bounds, none above)"
    assert lines["target 0.1"].get_ydata()[0] == 0.1
    assert lines[words].get_xdata()[0] == 1e3 * required
    assert lines["the gap, 20 mm"].get_xdata()[0] == 20.0
    (bar,) = [tuple(line.get_xdata()) for line in axis.get_lines() if line.get_linewidth() == 3.0]
    bounded = assessment.interfaces[0].required_at(90.0)
    assert bar == (1e3 * bounded.low, 1e3 * bounded.high) and not bounded.bounded
    assert axis.get_xlim()[1] > max(bar)  # nothing that is stated lies beyond the axis


def cells(built: model.Document) -> list[dict]:
    found = []
    for section in built["sections"]:
        for block in section["blocks"]:
            found += [cell for row in block.get("rows", []) for cell in row if isinstance(cell, dict)]
    return found


def test_every_number_of_the_page_is_the_models(built, html):
    """Each value in order, and beside it the same digits: nothing is rounded twice, nothing is left out."""
    shown = re.findall(r'<data value="([^"]*)">([^<]*)</data>', html)
    asked = []
    for cell in cells(built):
        if cell.get("raw") is not None:
            asked.append((str(cell["raw"]), cell["text"]))
        elif "parts" in cell:
            asked.append((" ".join(map(str, cell["parts"])), cell["text"]))
    assert len(asked) > 300
    assert shown == asked


def test_every_rounded_number_is_its_raw_value(built):
    """By the unit in the cell: half a unit of the third digit at most; required gaps are rounded up to it."""
    for cell in cells(built):
        if cell.get("raw") is None or "unit" not in cell:
            continue
        size, told = SIZE.get(cell["unit"], 1.0), float(cell["text"].split()[0])
        value, above = cell["raw"] * size, rounded_up(cell["raw"]) * size
        near = pytest.approx(value, rel=5.1e-2 if abs(value) < 1e-3 else 5.1e-3)
        assert told == near or (cell["unit"] == "m" and told == pytest.approx(above, rel=1e-9))


def test_long_tables_stand_whole_in_the_appendix(built):
    blocks = {section["name"]: section["blocks"] for section in built["sections"]}
    cut = next(block for block in blocks["adequacy"] if "motions with contact" in block.get("caption", ""))
    whole = next(block for block in blocks["appendix"] if block.get("anchor") == cut["more"]["anchor"])
    assert len(whole["rows"]) == 26 > LONG
    assert len(cut["rows"]) <= KEPT
    assert all(row in whole["rows"] for row in cut["rows"])
    # The scene's own gap is among the rows that stay.
    assert "40" in [row[0]["text"] for row in cut["rows"]]


def test_a_page_stands_alone(html, read):
    """No script, nothing from elsewhere; ids once each, and every reference finds its id."""
    assert not {"script", "link", "iframe", "img", "object", "form"} & set(read.tags)
    assert "@import" not in html
    assert all(place.startswith("#") for place in read.places)
    assert len(read.ids) == len(set(read.ids))
    inner = {place[1:] for place in read.places} | set(re.findall(r"url\(#([^)]*)\)", html))
    assert inner <= set(read.ids)
    assert set(re.findall(r"https?://[^\"' ]*", html)) <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_a_page_can_be_read_out(html, read):
    """A language, heads with scopes, captions, and a text for each figure that says more than its name."""
    assert read.root.get("lang") == "en"
    assert len(read.root.xpath("//@scope")) > 100
    assert html.count("<caption>") == read.tags.count("table")
    assert len(read.alts) == html.count("<figure id=") >= 6
    assert all(len(alt) > 60 for alt in read.alts)


def test_names_within_figures_are_told_apart_and_colours_stay():
    """A colour is no reference: prefixing every # once painted a curve away."""
    svg = '<svg id="a"><path id="m1" style="fill: #0072b2"/><use xlink:href="#m1" clip-path="url(#p#ff7f0e)"/></svg>'
    told = page.own_parts(svg, "one")
    assert told.count("#0072b2") == 1
    assert '<path id="one-m1"' in told
    assert 'xlink:href="#one-m1"' in told
    assert "url(#one-p" in told


def squeezed(text: str) -> str:
    """Letters and digits alone: how a PDF sets spaces, hyphens and indices is its own."""
    return re.sub(r"[\s\u200b_\u00ad-]", "", unicodedata.normalize("NFKC", text))


@cache
def pdf_text(content: bytes) -> str:
    reader = pytest.importorskip("pypdf").PdfReader(BytesIO(content))
    return "".join(squeezed(each.extract_text()) for each in reader.pages)


@pytest.mark.complete
def test_every_number_of_the_pdf_is_the_models(scan, built, html, pdf):
    """Row by row: the cells of each row stand in the PDF one after the other, after the conclusion; the command too."""
    text = pdf_text(pdf.read_bytes())
    in_order(scan, text)
    assert "oreport.pdf" in text and "report.html" not in text
    assert "-o report.html" in html and "report.pdf" not in html
    rows = [row for section in built["sections"] for block in section["blocks"] for row in block.get("rows", [])]
    numbers = [row for row in rows if any(isinstance(cell, dict) and "raw" in cell for cell in row)]
    assert len(numbers) > 80
    for row in numbers:
        parts = [squeezed(cell["text"] if isinstance(cell, dict) else cell) for cell in row]
        missing = [part for part in parts if part not in text]
        assert missing == [], row
        # A row of single lines is set in one go.
        if all(len(part) < 12 for part in parts):
            assert "".join(parts) in text, row


@pytest.mark.complete
def test_no_figure_of_the_pdf_stands_between_the_rows_of_a_table(built, pdf):
    text = pdf_text(pdf.read_bytes())
    blocks = [block for section in built["sections"] for block in section["blocks"]]
    numbered = [block for block in blocks if block["kind"] in ("table", "figure") and "number" in block]
    at = [text.index(squeezed(f"{block['kind'].title()} {block['number']}. {block['caption']}")) for block in numbered]
    assert at == sorted(at)
    for block, start in zip(numbered, at, strict=True):
        if block["kind"] == "table":
            last = squeezed("".join(cell["text"] for cell in block["rows"][-1][:2]))
            assert "Figure" not in text[start : text.index(last, start)]


@pytest.mark.complete
def test_the_pdf_is_tagged_and_holds_its_fonts(pdf):
    """Tags, which PDF/UA wants and typst refuses to write without a text for each figure; fonts within the file."""
    reader = pytest.importorskip("pypdf").PdfReader(pdf)
    assert not {"Project", "Revision", "Date"} & set(reader.pages[0].extract_text().split())  # it is not signed
    root = reader.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"]
    assert root["/Lang"] == "en"
    assert reader.metadata.title == "Made, not solved"
    fonts = [font.get_object() for each in reader.pages for font in each["/Resources"].get("/Font", {}).values()]
    kinds = [font["/DescendantFonts"][0].get_object()["/FontDescriptor"].get_object() for font in fonts]
    assert fonts
    assert all({"/FontFile", "/FontFile2", "/FontFile3"} & set(each) for each in kinds)


def test_words_of_a_user_are_words(built):
    """What is markup to HTML or to typst stands as it was written."""
    strange = {
        **built,
        "title": STRANGE,
        "sections": [{**built["sections"][0], "title": STRANGE}, built["sections"][1]],
    }
    text = page.page(strange)
    assert "<b>pair</b>" not in text
    assert text.count("A &lt;b&gt;pair&lt;/b&gt; &amp; ") >= 4
    pytest.importorskip("typst")
    assert pdf_text(document.document(strange)).count(squeezed(STRANGE)) >= 3


ALONE = """
import sys
for name in ("numba", "obspy", "pydantic", "llvmlite"):
    sys.modules[name] = None
import pounding_risk
for out in sys.argv[2:]:
    pounding_risk.report(sys.argv[1], out)
"""


@pytest.mark.complete
def test_the_same_dataset_gives_the_same_bytes_without_a_solver(results, html, pdf, tmp_path):
    """From the netCDF alone, in another process, with other hashes of strings, and no library that solves or reads."""
    names = [tmp_path / f"alone.{suffix}" for suffix in ("html", "pdf")]
    output("-c", ALONE, results, *names, env={**os.environ, "PYTHONHASHSEED": "7"})
    assert [name.read_bytes() for name in names] == [html.encode(), pdf.read_bytes()]


@pytest.mark.complete
def test_another_gap_and_amplitude_may_be_asked_of(tmp_path, no_pictures):
    """A study of two amplitudes: the tables are those of the one asked for, at the gap asked for."""
    kept = ["record_spectral_acceleration", "period", "record_pga"]
    weak, strong = made_scan(3, laws=1, seed=1), made_scan(3, laws=1, seed=2)
    parts = [each.drop_vars(kept).assign_coords(pga=pga) for each, pga in ((weak, 1.0), (strong, 3.0))]
    both = xr.concat(parts, dim="pga", combine_attrs="override").merge(weak[kept])
    for pga, one in ((None, strong), (1.0, weak)):
        out = pr.report(both, tmp_path / "report.html", gap=0.02, pga=pga)
        read = Page(out.read_text(encoding="utf-8"))
        told = {row[0][0]: row[1] for row in read.table("the numbers behind the verdict")}
        assert told["gap assessed"][0] == "20 mm"
        assert float(told["motions with contact"][0]) == int((one["peak_closing_free"] > 0.02).sum())
        force = one["peak_contact_force"].sel(gap=0.02, yield_force=2e5, contact_model="jankowski")
        row = read.table("outputs by contact model")[0]
        assert float(row[5][1][0]) == np.median(force.where(force > 0.0).values[(force > 0.0).values])


def test_letters_that_no_font_has_are_named(built, says):
    """U+0378 is no letter yet: no box stands for it in silence. Greek and Cyrillic come along."""
    pytest.importorskip("typst")
    strange = {**built, "sections": [{**built["sections"][0], "title": "Σ Жук \u0378"}]}
    says(refusal(document.document, strange))
    strange["sections"][0]["title"] = "Σ Жук ≤ √"
    assert squeezed("Σ Жук ≤ √") in pdf_text(document.document(strange))


def test_a_hazard_curve_adds_rates_and_a_target_its_verdict_and_gaps(tmp_path, no_pictures):
    """Rates and gaps of the page are those of the assessment, and its table says which gap is that of the target."""
    curve = tmp_path / "hazard.csv"
    curve.write_text("pga [g],return period [years]\n0.02,5\n0.2,100\n0.8,5000\n", encoding="utf-8")
    scan = made_scan(7, laws=1)
    asked = {"hazard": curve, "target_rate": "20 % in 50 years"}
    text = pr.report(scan, tmp_path / "report.html", **asked).read_text(encoding="utf-8")
    read, (one,) = Page(text), assess(scan, **asked).interfaces
    rates = [rate for rate in one.rates if np.isfinite(rate.annual)]
    known = [gap for gap in one.gaps_for_rates if not gap.fault]
    assert rates and known
    assert column(read.table("annual rates under"), 4) == [rate.annual for rate in rates]
    assert column(read.table("annual rates under"), 7) == [rate.below for rate in rates]
    assert column(read.table("The hazard curve hazard.csv"), 1) == [1.0 / 5.0, 0.01, 0.0002]
    assert column(read.table("The hazard curve hazard.csv"), 0) == pytest.approx([0.02 * G, 0.2 * G, 0.8 * G])
    assert column(read.table("gap that keeps contact to a rate under hazard.csv"), 2) == [gap.gap for gap in known]
    assert one.rate_verdict.conclusion[0].replace("&", "&amp;") in text
    assert "Return periods T are read as annual rates 1/T." in text
    assert "contacts a year at the gap assessed" in text
    assert any("20 % in 50 years" in gap.words for gap in one.gaps_for_rates)


def test_the_commands_make_the_same_report(scan, tmp_path):
    """The report names the file that the scan wrote, and every option that is not the usual one."""

    def blocks(dataset, **asked):
        return provenance.write(ReportData(with_axes(dataset), assess(dataset, **asked), {}, ""))

    curve = tmp_path / "hazard.csv"
    curve.write_text("pga [g],annual rate [1/year]\n0.05,0.1\n0.8,0.0005\n", encoding="utf-8")
    asked = {"gap": 0.0123456789, "percentile": 90.0, "target": 0.2, "confidence": 0.9, "hazard": curve}
    digest = hashlib.sha256(scan.attrs["scene_resolved"].encode()).hexdigest()
    told = scan.assign_attrs(
        command="pounding-risk scan pair.toml -o 'my pair.nc'", scene_sha256=digest, kernels_digest="0d"
    )
    found = {each["caption"]: each for each in blocks(told, **asked) if each.get("caption")}
    assert found["Commands."]["text"].splitlines()[1] == (
        "pounding-risk report 'my pair.nc' -o report.html --gap '0.0123456789 m' --percentile 90 --confidence 0.9 "
        "--target 0.2 --hazard hazard.csv"
    )
    digests = found["Digests."]["rows"]
    assert digest[:12] in str(digests[0][1]) and "0d" in str(digests[1][1])
    for rate, words in (("1 % in 50 years", "'1 % in 50 years'"), (1.0 / 2475.0, f"'{1.0 / 2475.0!r} a year'")):
        (commands,) = (
            each["text"] for each in blocks(scan, hazard=curve, target_rate=rate) if each.get("caption") == "Commands."
        )
        assert f"--hazard hazard.csv --target-rate {words}" in commands
    plain = {line for each in blocks(scan) for line in each.get("text", "").splitlines()}
    assert "pounding-risk report results.nc -o report.html" in plain


def test_the_command_writes_and_replaces_nothing_unasked(tmp_path, monkeypatch, no_pictures):
    monkeypatch.chdir(tmp_path)
    save(made_scan(2, laws=1), tmp_path / "results.nc")
    first = commands.run("report", "results.nc")
    assert (first.exit_code, first.output) == (0, "written: results.html\n")
    assert "results.html exists already" in commands.refused("report", "results.nc")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["results.html", "results.nc"]


def test_datasets_beside_the_scan_stand_in_the_provenance(scan, tmp_path):
    """Their files and checksums, and the option that names them in the command."""
    beside = tmp_path / "effects.nc"
    xr.Dataset({"time_ratio": ("effects", [1.0])}).to_netcdf(beside)
    told = json.dumps(provenance.write(ReportData(with_axes(scan), assess(scan), companions([beside]), "")))
    assert f"effects: {beside}, sha256" in told
    assert hashlib.sha256(beside.read_bytes()).hexdigest() in told
    assert f"-o report.html --with {beside}" in told


EFFECTS = xr.Dataset({"time_ratio": ("effects", [1.0])})
REFUSED = {
    "two lines as an author": {"author": "A\nB"},
    "a number as a date": {"date": 2026},
    "a long project": {"project": "x" * 201},
    "no counts": "impact_count",
    "no closings": "peak_closing_free",
    "effects alone": EFFECTS,
    "two of effects": {"also": [EFFECTS, EFFECTS]},
    "another scan beside it": {},
    "no report": {},
    "damaged records": {},
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_makes_no_report_is_refused(scan, case, says, tmp_path):
    given, options = scan, REFUSED[case]
    if isinstance(options, xr.Dataset | str):
        given, options = (scan.drop_vars(options) if isinstance(options, str) else options), {}
    if case == "another scan beside it":
        options = {"also": [scan]}
    if case == "damaged records":
        given = scan.assign_attrs(records="[{")
    path = tmp_path / ("report.doc" if case == "no report" else "report.html")
    says(refusal(pr.report, given, path, **options))
    assert list(tmp_path.iterdir()) == []


def test_a_pdf_without_typst_is_told_how(built, says, monkeypatch):
    monkeypatch.setitem(sys.modules, "typst", None)
    says(refusal(document.document, built))


def test_a_section_is_a_module_of_its_folder_or_a_row_of_answers():
    """Found by listing the folder, each with a title and a place of its own."""
    names = {file.stem for file in Path(sections.__file__).parent.glob("[!_]*.py")} - {"answers"}
    modules = {name: import_module(f"{sections.__name__}.{name}") for name in names}
    orders = {name: module.ORDER for name, module in modules.items()} | {row[0]: row[1] for row in answers.ROWS}
    assert list(model.SECTIONS) == sorted(orders, key=orders.__getitem__)
    assert len({section.title for section in model.SECTIONS.values()}) == len(set(orders.values())) == len(orders)
