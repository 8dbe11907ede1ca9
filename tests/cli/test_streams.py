"""Commands as real processes whose standard output is closed, full, or of an encoding without our characters."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from sweeps import sweep

from pounding_risk.cli._common.compile_cache import report_trouble
from pounding_risk.cli._common.streams import PLAIN, in_ascii
from pounding_risk.figures.style import blank, write

MODELS = f'{sys.executable} -c "import pounding_risk.cli as cli; cli.main()" models'
posix = pytest.mark.skipif(os.name == "nt", reason="the words are a POSIX shell's")


def shell(line: str, cwd: Path, **variables: str) -> subprocess.CompletedProcess[bytes]:
    """A line that a shell runs in a folder."""
    return subprocess.run(
        ["sh", "-c", line], cwd=cwd, env={**os.environ, **variables}, capture_output=True, timeout=120, check=False
    )


@posix
@pytest.mark.parametrize("encoding", sweep(["ascii", "cp1252"], "ascii"))
def test_characters_that_an_encoding_lacks_are_written_in_others(encoding, tmp_path):
    run = shell(MODELS, tmp_path, PYTHONIOENCODING=encoding)
    text = run.stdout.decode(encoding)
    assert run.returncode == 0 and not run.stderr and "?" not in text
    assert "F = max(0, k delta + c delta')" in text


@posix
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
@pytest.mark.parametrize("words", ["", "--version"], ids=["more than a buffer", "less than a buffer"])
def test_a_full_output_is_a_sentence(words, tmp_path):
    run = shell(f"{MODELS.removesuffix('models')} {words or 'models'} > /dev/full", tmp_path)
    assert run.returncode == 2
    assert run.stderr.startswith(b"pounding-risk: standard output cannot be written (No space left on device); free")
    assert run.stderr.count(b"\n") == 1


@posix
@pytest.mark.parametrize("closing", sweep([">&-", ">&- 2>&-"], ">&- 2>&-"))
def test_a_closed_output_does_not_stop_a_command(closing, tmp_path):
    run = shell(f"{MODELS} {closing}", tmp_path)
    assert (run.returncode, run.stdout, run.stderr) == (0, b"", b"")


@posix
def test_a_reader_that_has_gone_is_no_fault(tmp_path):
    assert shell(f"{MODELS} | true", tmp_path).stderr == b""


@posix
@pytest.mark.complete
def test_a_nonsense_backend_of_windows_does_not_matter(tmp_path):
    line = MODELS.replace(
        " models", " impact --law hertz --stiffness '2.75e9 N/m^1.5' --mass '570 kg' --speed '0.5 m/s'"
    )
    run = shell(f"{line} --figure f.svg", tmp_path, MPLBACKEND="nonsense", NUMBA_DISABLE_JIT="1")
    assert run.returncode == 0 and (tmp_path / "f.svg").is_file(), run.stderr.decode()


def test_settings_of_numba_that_cannot_be_read_are_a_sentence(tmp_path):
    (tmp_path / ".numba_config.yaml").write_text("threads: [", "utf-8")
    run = shell(MODELS, tmp_path)
    assert run.returncode == 2
    assert run.stderr.startswith(
        b"pounding-risk: .numba_config.yaml in this folder: numba cannot read it (ParserError: "
    )


@pytest.mark.parametrize(
    ("text", "plain"), [("ξ(e) ≤ 5 m/s²", "xi(e) <= 5 m/s^2"), ("é–β₀Δ", "e-beta0Delta"), ("語", "?")]
)
def test_replacements_are_ascii(text, plain):
    assert "".join(character if character.isascii() else in_ascii(character) for character in text) == plain


def test_every_replaced_sign_has_one():
    assert all(len(sign) == 1 and in_ascii(sign).isascii() and "?" not in in_ascii(sign) for sign in PLAIN)


def test_letters_that_the_font_of_figures_lacks_are_one_sentence(tmp_path, capsys):
    """Matplotlib warns of each letter at each drawing."""
    figure, axes = blank()
    axes[0, 0].set_title("山田 | ビル")
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        with report_trouble():
            write(figure, tmp_path / "name.png")
    (told,) = capsys.readouterr().err.splitlines()
    words = "figures show boxes for letters such as 山, which DejaVu Sans lacks; write names in others"
    assert told == f"pounding-risk: note: {words}"
