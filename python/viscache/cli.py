"""The command line: `viscache SUB-COMMAND ...`.

Results go to standard output, messages and progress to standard error. Exit status: 0 done, 1 a
check or comparison failed, 2 bad usage or input (one line; a traceback with --debug), 130 after
Ctrl-C.
"""

from __future__ import annotations

import argparse
import errno
import importlib
import sys
from collections.abc import Sequence
from functools import cache
from importlib import metadata
from typing import Any

from viscache.base.provenance import VERSION
from viscache.settings.spelling import nearest

#: Sub-command → description. The module of the same name in `viscache.commands` implements it.
#: More come from other packages: their entry points of the group `viscache.commands` name modules
#: with `add_arguments(parser)`, `run(arguments) -> exit status` and a docstring of one line.
COMMANDS = {
    "scenes": "the built-in procedural scenes, their parameters and defaults",
    "params": "the parameters of integrators, rays and caches, with defaults and ranges",
    "info": "what a scene holds, and what its file asked for that is not modelled",
    "render": "render a scene to an EXR file",
    "diff": "compare an image with a reference",
    "correlate": "Section 4 statistics of a scene's visibility",
    "sweep": "run or resume a sweep of a file, or of a scene over some parameters",
    "tune": "the quantized cache's C_E for an error target",
    "report": "write the HTML report of a sweep",
}
OK, FAILED, BAD_USAGE, INTERRUPTED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command line; returns the exit status and never raises for bad input."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given
    try:
        parser = _parser(given)
        parsed = parser.parse_args(given)
        return int(_module(parsed.command).run(parsed))
    except SystemExit as stop:  # argparse has printed the reason
        return stop.code if isinstance(stop.code, int) else BAD_USAGE
    except KeyboardInterrupt:
        if debug:
            raise
        print("viscache: interrupted; what was finished is kept", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()
        return OK
    except (ValueError, OSError, MemoryError) as error:
        if debug:
            raise
        return _complain(_reason(error))


@cache
def _added() -> dict[str, metadata.EntryPoint]:
    """The sub-commands of other packages."""
    return {found.name: found for found in metadata.entry_points(group="viscache.commands")}


def _module(name: str) -> Any:
    if name in COMMANDS:
        return importlib.import_module(f"viscache.commands.{name}")
    try:
        return _added()[name].load()
    except (ImportError, AttributeError) as error:
        raise ValueError(f"the package of command {name!r} must load, got {error}") from error


def _about(name: str) -> str:
    """What a sub-command does: of other packages, the first line of its module's docstring."""
    if name in COMMANDS:
        return COMMANDS[name]
    line = str(_module(name).__doc__ or name).partition("\n")[0].rstrip(".")
    return line[0].lower() + line[1:]


def _listed(name: str) -> str:
    """The same for the list of all, where one that does not load has its reason."""
    try:
        return _about(name)
    except ValueError as error:
        return str(error)


def _parser(given: Sequence[str]) -> argparse.ArgumentParser:
    """The parser. Only the sub-command in use is imported and adds its arguments."""
    parser = _Parser(prog="viscache", description="Trade shadow rays for accuracy, and measure it.")
    parser.add_argument("--version", action="version", version=f"viscache {VERSION}")
    parser.add_argument("--debug", action="store_true", help="tracebacks instead of one line")
    subs = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    wanted = next((word for word in given if not word.startswith("-")), None)
    known = COMMANDS if wanted in COMMANDS else {**_added(), **COMMANDS}
    if wanted is not None and wanted not in known:
        raise ValueError(f"unknown command {wanted!r}{nearest(wanted, known)}")
    for name in known if wanted is None else [wanted]:
        text = (_about if name == wanted else _listed)(name).replace("%", "%%")
        sub = subs.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        sub.add_argument(
            "--debug",
            action="store_true",
            default=argparse.SUPPRESS,
            help="tracebacks instead of one line",
        )
        if name == wanted:
            _module(name).add_arguments(sub)
    return parser


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage."""

    def error(self, message: str) -> None:  # type: ignore[override]
        self.exit(BAD_USAGE, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _reason(error: Exception) -> str:
    if isinstance(error, MemoryError):
        told = str(error)
        if told and "bad_alloc" not in told:
            return told
        return "there is not enough memory for this (a smaller --size needs less)"
    told = str(error)
    if isinstance(error, OSError) and error.strerror and error.filename:
        told = f"{error.filename}: {error.strerror}"
    hint = _what_to_do(error)
    return f"{told}; {hint}" if hint else told


#: What to do about a disk, by the error's number.
DISK_HINTS = {
    errno.ENOSPC: "make room and run the same command again: what is finished is kept",
    errno.EDQUOT: "make room and run the same command again: what is finished is kept",
    errno.EFBIG: "raise the limit on the size of files (ulimit -f) and run the same command again",
    errno.EROFS: "choose a folder that can be written to",
    errno.EACCES: "choose a folder and files that you may read and write",
    errno.EPERM: "choose a folder and files that you may read and write",
}


def _what_to_do(error: BaseException | None) -> str | None:
    """The hint for an error of a disk, or for the one that caused it."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in DISK_HINTS:
            return DISK_HINTS[error.errno]
        error = error.__cause__
    return None


def _complain(message: str) -> int:
    print("viscache: " + " ".join(message.split()), file=sys.stderr)
    return BAD_USAGE


if __name__ == "__main__":
    sys.exit(main())
