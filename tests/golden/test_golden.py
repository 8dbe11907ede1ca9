"""Every command on the shipped scenes says what its file says: the same words, the same numbers."""

import pytest
import sentences
from golden_commands import COMMANDS, FILES, differences, outputs

NAMES = list(COMMANDS)


@pytest.fixture(scope="session")
def texts(shared_once, tmp_path_factory) -> dict[str, str]:
    """What each command prints and writes."""
    return shared_once("golden", lambda: dict(outputs(tmp_path_factory.mktemp("golden"))))


@pytest.mark.parametrize("name", NAMES)
def test_a_command_says_what_its_file_says(texts, name, pytestconfig):
    """``pytest --rewrite tests/golden`` writes the files anew, to be read before they are committed."""
    if pytestconfig.getoption("--rewrite"):
        (FILES / f"{name}.txt").write_text(texts[name], encoding="utf-8")
    found = differences(texts[name], (FILES / f"{name}.txt").read_text(encoding="utf-8"))
    assert not found, f"{name}:\n" + "\n".join(found[:40])


def test_every_file_is_of_a_command():
    assert {file.stem for file in FILES.glob("*.txt")} == set(NAMES)


def test_every_paragraph_is_of_a_test():
    """A test that is gone takes its sentences with it."""
    for file in sentences.FILES.rglob("*.txt"):
        module = (sentences.TESTS / file.relative_to(sentences.FILES)).with_suffix(".py")
        source = module.read_text(encoding="utf-8")
        for name in sentences.sentences(file):
            assert f"def {name.partition('[')[0].partition(' ')[0]}(" in source, f"{file}: {name}"


@pytest.mark.parametrize(
    ("text", "kept", "is_alike"),
    [
        ("gap 1.23 mm", "gap  1.22 mm", True),
        ("gap 1.24 mm", "gap 1.22 mm", False),
        ("error 2e-05", "error 3e-05", True),
        ("gap 12 m", "gap 12 mm", False),
        ("a\nb", "a", False),
    ],
)
def test_numbers_may_be_one_apart_in_their_last_digit(text, kept, is_alike):
    assert (not differences(text, kept)) == is_alike


@pytest.mark.parametrize(("kept", "is_alike"), [("1e-05", False), ("1e-06", True), ("0.16", False), ("2.7183", True)])
def test_limits_in_sentences_are_exact(kept, is_alike):
    text = {"1e-05": "1e-06", "0.16": "0.17", "2.7183": "2.7184"}.get(kept, kept)
    assert (not differences(f"at most {text} m", f"at most {kept} m", exact=3)) == is_alike
