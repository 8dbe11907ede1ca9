"""The command line: each command reads its options, makes one call of the Python API, and prints what came of it.

A command is the module of its name in this folder. Everything but typer is imported when a command runs, and a command
itself when it is run or listed, so that help and completion answer at once.
"""

from __future__ import annotations

import errno
import os
import sys
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stdout, suppress
from typing import Annotated, Any, cast

import typer

from pounding_risk._common.letters import plain
from pounding_risk.cli._common.commands import FolderGroup, group_of
from pounding_risk.cli._common.compile_cache import report_trouble
from pounding_risk.cli._common.options import BAD_INPUT, INTERRUPTED
from pounding_risk.cli._common.streams import OutputFull, prepare_streams
from pounding_risk.errors import PoundingError
from pounding_risk.questions import declared_questions


class Commands(FolderGroup):
    """The group of all commands. Errors that a user can repair are printed as sentences, without a traceback."""

    plugins = "commands"
    questions = declared_questions()

    def invoke(self, ctx: Any) -> Any:
        """Run a command; bad input ends with status 2, Ctrl-C with 130."""
        with _sentences(), _set_hint():
            return super().invoke(ctx)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands to the help; those of plug-ins are imported for it."""
        with _sentences():
            super().format_commands(ctx, formatter)


class PlainText:
    """A stream on which no text of a scene, of a dataset or of a plug-in can steer the terminal."""

    def __init__(self, stream: Any):
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text with its control characters as ``\\u001b``."""
        self._stream.write(plain(text))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write texts one after another, each as `write` does."""
        for line in lines:
            self.write(line)


@contextmanager
def _sentences() -> Iterator[None]:
    """Errors that a user can repair become a sentence and an exit status."""
    try:
        output = nullcontext() if sys.stdout is None else redirect_stdout(cast(Any, PlainText(sys.stdout)))
        with report_trouble(), _missing_variable_sentence(), output:
            yield
    except PoundingError as error:
        typer.echo(plain(f"pounding-risk: {error}"), err=True)
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:  # a name too long, a full disk: no fault of the code, wherever it occurs
        from pounding_risk._common.files import AGAIN, FULL, raised

        if error.filename is None and error.errno not in FULL:
            raise
        name = error.filename or "a file, or one of those that are needed for it"
        repair = "choose another name or place"
        if error.errno in FULL:
            repair = raised(AGAIN) if error.errno == errno.EFBIG else AGAIN
        typer.echo(plain(f"pounding-risk: {name}: {error.strerror}; {repair}"), err=True)
        raise typer.Exit(BAD_INPUT) from None
    except KeyboardInterrupt as stop:
        kept_text = str(stop) or "no file was left half written"
        typer.echo(plain(f"pounding-risk: stopped by Ctrl-C; {kept_text}"), err=True)
        raise typer.Exit(INTERRUPTED) from None


@contextmanager
def _set_hint() -> Iterator[None]:
    """Name ``--set``, which takes any key of the scene, for an unknown option of a command that has it."""
    try:
        yield
    except Exception as error:
        unknown: Any = error
        command = getattr(getattr(error, "ctx", None), "command", None)
        if hasattr(error, "possibilities") and any("--set" in item.opts for item in getattr(command, "params", ())):
            unknown.message += "; a key of the scene is changed with --set, such as --set interface.gap='20 mm'"
        raise


@contextmanager
def _missing_variable_sentence() -> Iterator[None]:
    """As `check.missing_named`, which is imported where a command ends in such an error alone."""
    try:
        yield
    except KeyError as error:
        from pounding_risk.results.check import missing_named

        with missing_named():
            raise error


app = typer.Typer(
    cls=group_of(__name__, __path__, Commands),
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def main() -> None:
    """Run the command line; the entry point of ``pounding-risk``."""
    _block_imports(sys.argv[1:])
    os.environ["MPLBACKEND"] = "agg"  # commands draw to files, whatever the user's windows are
    prepare_streams()
    try:
        try:
            app(prog_name="pounding-risk")
        finally:
            with suppress(BrokenPipeError):
                sys.stdout.flush()
    except OutputFull as full:
        sentence = f"pounding-risk: standard output cannot be written ({full}); free space, or send it elsewhere"
        typer.echo(sentence, err=True)
        sys.exit(BAD_INPUT)
    except SystemExit as end:
        _exit_past_threads(end)
        raise
    except KeyboardInterrupt:  # before a command is reached, or a second one on the way out
        _exit_past_threads(SystemExit(INTERRUPTED))
        sys.exit(INTERRUPTED)


def _block_imports(words: Sequence[str]) -> None:
    """Keep libraries from importing Dask and pint for a command that has no use for them.

    xarray imports both wherever they are installed, to know their arrays, and pint Dask; Dask takes longer than all
    else that a command imports. Only Zarr stores and clusters need it. Pint is there for unusual units: `units` takes
    it in spite of this.
    """
    unused = ["pint"]
    if not any(word.startswith("--scheduler") or ".zarr" in word.lower() for word in words):
        unused.append("dask")
    for name in unused:
        sys.modules.setdefault(name, None)  # type: ignore[arg-type] # so that importing it fails


def _exit_past_threads(end: SystemExit) -> None:
    """Exit at once where threads still run a kernel, which cannot be interrupted.

    The usual exit would finalise the interpreter while they run.
    """
    if "pounding_risk.ensemble.threads" not in sys.modules:
        return
    from pounding_risk.ensemble.threads import WORKER

    if not any(thread.daemon and thread.name.startswith(WORKER) for thread in threading.enumerate()):
        return
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):  # a pipe whose reader has gone
            stream.flush()
    os._exit(end.code if isinstance(end.code, int) else int(end.code is not None))


def _version(is_asked: bool) -> None:
    if is_asked:
        from pounding_risk import __version__

        typer.echo(f"pounding-risk {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and stop.")
    ] = False,
) -> None:
    """Seismic pounding of adjacent buildings: is this gap enough, and what gap would be?

    Quantities have units: "44.36 t", "25 mm", "0.5 g". In a shell, quote them.
    """
