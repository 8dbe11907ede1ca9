"""Commands made from questions (`pounding_risk.questions`): the options, the run, and what is printed and written."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common import options as shared
from pounding_risk.cli._common.files import FIGURES, announce, draw, out_or, writing
from pounding_risk.cli._common.options import RUN_FAILED, Fields, file_option, out_option, with_options
from pounding_risk.cli._common.outline import Outline
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli._common.subjects import SUBJECTS
from pounding_risk.errors import PoundingError
from pounding_risk.questions import Declared, source_of
from pounding_risk.questions._declaration import File, Option

SHARED = {
    "workers": shared.Workers, "hazard": shared.Hazard, "gmfs": shared.Gmfs, "new": shared.New, "out": None,
    "progress": None, "say": None, "select": shared.Select,
}  # fmt: skip
EMPTY: tuple[Any, ...] = (None, (), [], "")
_ENTRY = re.compile(r"^(\w+(?:, \w+)*) : .*$")


def command_of(declared: Declared) -> Callable[..., None]:
    """The function of a command, which runs a question, prints its sheet and writes its files."""
    question = Question(declared)
    return with_options(question.run, question.fields(), question.summary)


class Question:
    """A question as a command: its options from outlines of its modules, which are imported where it is answered."""

    def __init__(self, declared: Declared):
        self.declared, self.name, self.outline = declared, declared.name, Outline(declared.source)
        self.function = Outline(declared.source_of_function())[self.name]
        answer, sheet = (getattr(self.outline, name, None) for name in ("answer", "sheet"))
        functions = [function for function in (self.function, answer) if function is not None]
        if answer is not None:
            kinds = {item.kind for item in inspect.signature(answer).parameters.values()}
            functions = functions if Parameter.VAR_KEYWORD in kinds else [answer]
        if passed := getattr(self.outline, "PASSED", ""):
            home, _, name = passed.rpartition(".")
            functions.insert(0, Outline(source_of(home))[name])
        self.takes = {name: item for function in functions for name, item in _parameters(function).items()}
        self.sheet_takes = {} if sheet is None else dict([*_parameters(sheet).items()][1:])
        self.first = next(iter(self.takes))
        kind = f"optional {self.first}" if self.takes[self.first].default is None else self.first
        self.subject = SUBJECTS.get(getattr(self.outline, "SUBJECT", kind))
        self.figures: dict[str, Any] = getattr(self.outline, "FIGURES", {})
        self.options: dict[str, Option | None] = getattr(self.outline, "OPTIONS", {})
        self.files: dict[str, Any] = getattr(self.outline, "FILES", {})
        self.writes = sheet is None
        self.texts = {name: text for item in (sheet, *functions) for name, text in parameters_of(item).items()}

    @property
    def summary(self) -> str:
        """The first line of the function's docstring, and further lines of the module's ``HELP``."""
        first = (inspect.getdoc(self.function) or "").partition("\n")[0]
        return "\n\n".join(filter(None, (first, getattr(self.outline, "HELP", ""))))

    # ------------------------------------------------------------------------------------------------- options

    def fields(self) -> Fields:
        """Annotation, as typer takes it, and default of each argument and option by the name of its parameter."""
        fields = {} if self.subject is None else dict(self.subject.fields)
        for name, parameter in (self.takes | self.sheet_takes).items():
            if (name != self.first or self.subject is None) and self.options.get(name, Option()) is not None:
                fields |= self._field_of_parameter(name, parameter.default, str(parameter.annotation))
        for name, option in self.options.items():
            if option is not None and name not in fields:
                fields |= self._field_of_parameter(name, None, "")
        if "hazard" in fields:
            fields["site"] = (shared.Site, None)
        suffixes, out_file = self._suffixes(), self.files.get("out", File((), ""))
        if suffixes:
            words, absence = out_file.description or "Write the answer", out_file.usual.format(self.first.upper())
            fields["out"] = (Annotated[Path | None, out_option(words, *suffixes, absence=absence)], None)
        if ".nc" in suffixes and not self.writes:
            fields["new"] = (shared.New, False)
        for name, file in self.files.items():
            if name != "out":
                fields[name] = (Annotated[Path | None, file_option(file.description, file.suffixes)], None)
        for name in self.figures:
            if name.startswith("-"):
                continue
            words = "Write a figure" if not name else f"Write a figure of {name}"
            flag = "--figure" if not name else f"--{name}-figure"
            fields[_figure_field(name)] = (Annotated[Path | None, file_option(words, FIGURES, flag)], None)
        if hasattr(self.outline, "failed"):
            fields["strict"] = (shared.Strict, False)
        return fields

    def _field_of_parameter(self, name: str, default: Any, annotation: str) -> Fields:
        """The field of a parameter; none if the command gives its value itself."""
        is_needed = default is Parameter.empty
        default = None if default in (Parameter.empty, (), None, "") else default
        if name in SHARED:
            return {} if SHARED[name] is None else {name: (SHARED[name], default)}
        option = self.options.get(name) or Option()
        kind = option.kind or _kind(annotation)
        if kind == list[str]:
            default = None
        elif isinstance(default, list | tuple):
            default = tuple(map(str, default)) if kind == tuple[str, str] else tuple(default)
        elif default is False and kind is not bool:
            default = None
        # A number stays the function's own default: its text would lack the unit.
        shown_default: Any = bool(default)
        if kind is str and isinstance(default, int | float):
            default, shown_default = None, f"{default:g}"
        settings: dict[str, Any] = {"help": option.help or self.texts.get(name, "").replace("`", "")}
        if kind == list[str] and not option.is_argument and "twice" not in settings["help"]:
            settings["help"] += " Repeat for several."
        if option.metavar or kind == list[str]:
            settings["metavar"] = option.metavar or "TEXT"
        kind = kind if kind is bool or is_needed else kind | None
        default = Parameter.empty if is_needed else bool(default) if kind is bool else default
        if option.is_argument:
            return {name: (Annotated[kind, typer.Argument(show_default=False, **settings)], default)}
        flag = self._flag(name)
        flags = [f"{flag}/--no-{flag.removeprefix('--')}"] if kind is bool else option.flag.split() or [flag]
        return {name: (Annotated[kind, typer.Option(*flags, show_default=shown_default, **settings)], default)}

    def _suffixes(self) -> tuple[str, ...]:
        """Kinds of files that the answer can be written to."""
        suffixes = self.files["out"].suffixes if "out" in self.files else ()
        if self.writes:
            return suffixes
        is_dataset = "out" in self.takes or "Dataset" in str(inspect.signature(self.function).return_annotation)
        kinds = [*suffixes] if ".nc" in suffixes or not is_dataset else [".nc", *suffixes]
        return tuple(dict.fromkeys([*kinds, ".csv", ".html"]))

    # ----------------------------------------------------------------------------------------------------- run

    def run(self, options: dict[str, Any]) -> None:
        """Answer the question, write the files that are asked for, and print the sheet."""
        given_options = {name: option for name, option in options.items() if option not in EMPTY}
        out: Path | None = given_options.get("out")
        dataset = out if out is not None and out.suffix.lower() == ".nc" else None
        if self.writes and "out" in self.files:
            dataset = out_or(out, self.files["out"].usual.format(options[self.first].stem))
        module: Any = self.declared.module()
        if dataset is not None and "out" not in self.takes:
            from pounding_risk.ensemble.replacing import check_replaceable

            check_replaceable(dataset, self.name, None, options["new"])
        flags = {name: self._flag(name) for name in options}
        flags_by_words = {flags[name].removeprefix("--").replace("-", " "): flags[name] for name in given_options}
        with _named_by_option(self.name, flags_by_words | flags):
            check = getattr(module, "check", lambda _: None)
            check(given_options)
            subject = {} if self.subject is None else {self.first: self.subject.open(options)}
            check(given_options | subject)
            _join_site(options)
            function = getattr(module, "answer", None) or self.declared.function()
            answer = self._answer(function, _picked(self.takes, options | {"out": dataset}) | subject)
            if self.writes:
                files = getattr(answer, "files", answer)
                blocks, paths = [], [files] if isinstance(files, Path) else files
            else:
                blocks = module.sheet(answer, **_picked(self.sheet_takes, options))
                paths = [
                    *self._write_files(module, answer, blocks, given_options),
                    *self._draw_figures(module, answer, options),
                ]
        from pounding_risk.render.terminal import print_sheet

        print_sheet(blocks)  # after the files: a reader of the first lines alone, such as `head`, ends the printing
        announce(*paths)
        for sentence in getattr(module, "notes", lambda _: ())(answer):
            print(sentence)
        if options.get("strict") and module.failed(answer):
            raise typer.Exit(RUN_FAILED)
        if code := getattr(module, "status", lambda _: 0)(answer):
            raise typer.Exit(code)

    def _answer(self, function: Callable[..., Any], arguments: dict[str, Any]) -> Any:
        """The answer, with progress on standard error where the function reports any."""
        if "say" in self.takes:
            arguments["say"] = typer.echo
        if "progress" not in self.takes:
            return function(**arguments)
        with ProgressDisplay(self.name, getattr(self.outline, "UNIT", "cases")) as progress:
            return function(**arguments, progress=progress)

    def _write_files(self, module: Any, answer: Any, blocks: Any, chosen: Mapping[str, Any]) -> Iterator[Path]:
        """Write the answer to the files that are given; gives each that is written."""
        files = getattr(module, "FILES", {})
        for name in dict.fromkeys(("out", *files)):
            target, file = chosen.get(name), files.get(name)
            if target is None:
                continue
            with writing(target):
                if file is not None and target.suffix.lower() in file.suffixes:
                    (_function(file.write) if isinstance(file.write, str) else file.write)(answer, target)
                else:
                    self._write_by_suffix(answer, blocks, target)
            yield target

    def _write_by_suffix(self, answer: Any, blocks: Any, target: Path) -> None:
        """Write the dataset, unless the function has done so, the tables or the page of an answer, by the suffix."""
        kind = target.suffix.lower()
        if kind == ".csv":
            from pounding_risk._common.written import write_file
            from pounding_risk.render.csv_text import csv_text

            write_file(target, csv_text(blocks))
        elif kind == ".html":
            from pounding_risk.reports.pages import write_sheet_page

            write_sheet_page(target, self.summary, blocks)
        elif "out" not in self.takes:
            from pounding_risk.results.files import save

            save(answer, target)

    def _draw_figures(self, module: Any, answer: Any, options: Mapping[str, Any]) -> Iterator[Path]:
        """Draw the figures that are asked for; gives the file of each."""
        for name, figure in getattr(module, "FIGURES", {}).items():
            target = options.get(_figure_field(name))
            if name.startswith("-") and (first_target := options["figure"]) is not None:
                target = first_target.with_stem(f"{first_target.stem}{name}")
            drawing = figure(answer) if callable(figure) else figure
            if target is None or not drawing:
                continue
            shown = module.drawn(answer) if hasattr(module, "drawn") else answer
            draw(target, drawing, shown, **_picked(_parameters(_function(f"figures.{drawing}")), options), quiet=True)
            yield target

    def _flag(self, name: str) -> str:
        option = self.options.get(name)
        return (option and option.flag.partition(" ")[0]) or f"--{name.replace('_', '-')}"


@contextmanager
def _named_by_option(name: str, flags: Mapping[str, str]) -> Iterator[None]:
    """Replace the name of a parameter, or its option in words, at the beginning of an error by the option."""
    try:
        yield
    except PoundingError as error:
        for text in (str(error), str(error).removeprefix(f"{name}: ")):  # as in "simulate: gap: ..."
            parameter, colon, sentence = text.partition(":")
            if colon and (flag := flags.get(parameter, flags.get(parameter.lower()))):
                raise PoundingError(f"{flag}:{sentence}") from None
        raise


def parameters_of(function: Any) -> dict[str, str]:
    """Description of each parameter in the docstring of a function, one paragraph each (numpydoc)."""
    lines = (inspect.getdoc(function) or "").split("\n") if function is not None else []
    if "Parameters" not in lines:
        return {}
    parameters: dict[str, list[str]] = {}
    names: list[str] = []
    for line in lines[lines.index("Parameters") + 2 :]:
        if entry := _ENTRY.match(line):
            names = entry[1].split(", ")
            parameters |= {name: [] for name in names}
        elif line and not line.startswith(" "):
            break
        else:
            for name in names:
                parameters[name].append(line.strip())
    return {name: " ".join(filter(None, words)) for name, words in parameters.items()}


def _kind(annotation: str) -> Any:
    """Type of an option from the annotation of its parameter."""
    words = set(re.findall(r"[\w.]+", annotation))
    if words & {"Sequence", "Iterable", "tuple", "list"}:
        return list[str]
    if words & {"Path", "Any"}:
        return Path
    if "str" in words:
        return str
    return next((kind for kind in (bool, int, float) if kind.__name__ in words), str)


def _parameters(function: Callable[..., Any]) -> dict[str, Parameter]:
    parameters = inspect.signature(function).parameters
    return {name: parameter for name, parameter in parameters.items() if parameter.kind != Parameter.VAR_KEYWORD}


def _picked(parameters: Mapping[str, Parameter], options: Mapping[str, Any]) -> dict[str, Any]:
    """The options for these parameters; an option that is not given is left to its default."""
    return {name: option for name, option in options.items() if name in parameters and option not in EMPTY}


def _function(name: str) -> Callable[..., Any]:
    """The function of a name below `pounding_risk`, "module.function"."""
    module, _, function = name.rpartition(".")
    return getattr(import_module(f"pounding_risk.{module}"), function)


def _figure_field(name: str) -> str:
    return f"{name.replace('-', '_')}_figure" if name else "figure"


def _join_site(options: dict[str, Any]) -> None:
    """Put the site of ``--site`` behind the name of the file that has it."""
    site = options.pop("site", None)
    if site is None:
        return
    from pounding_risk.motions.sites.places import read_site

    read_site(site, "--site")
    names = [name for name in ("gmfs", "hazard") if name in options]
    option_name = next((name for name in names if options[name] is not None), None)
    if option_name is None:
        files = " or ".join(f"--{name}" for name in reversed(names))
        raise PoundingError(f"--site: is the site of a file of {files}; name one, or leave --site out")
    options[option_name] = Path(f"{options[option_name]}#{site}")
