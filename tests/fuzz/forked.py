"""Runs one case in a forked child with limits of memory and time: no case may stop the tests."""

import faulthandler
import math
import os
import resource
import select
import signal
import time
from collections.abc import Callable
from pathlib import Path

from fuzz.outcome import Outcome, of_error

LIMIT_BYTES = 4 << 30
#: Of the processor, so that busy machines do not look like hangs; by the clock three times as long.
LIMIT_S = 20.0


def outcome(case: Callable[[], object], folder: Path, limit_s: float = LIMIT_S) -> Outcome:
    """What `case()` comes to in a child of this process, whose working folder is `folder`."""
    end, begin = os.pipe()
    log = folder / "stderr.txt"
    child = os.fork()
    if child == 0:
        os.close(end)
        _in_child(case, begin, folder, log, limit_s)
    os.close(begin)
    said, in_time = _read(end, 3 * limit_s)
    os.close(end)
    if not in_time:  # faulthandler writes the stack on SIGABRT
        os.kill(child, signal.SIGABRT)
        time.sleep(0.2)
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    kind, _, text = said.partition(b"\n")
    if in_time and kind.decode() in ("works", "refused", "wrong", "unclean"):
        return Outcome(kind.decode(), text.decode(errors="replace"))
    told = log.read_text(errors="replace") if log.exists() else ""
    last = told.partition("\nExtension modules")[0][:1500]
    if not in_time or (os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU):
        return Outcome("hangs", f"after {limit_s:g} s: {last}")
    return Outcome("killed", f"status {status}: {last}")


def _in_child(
    case: Callable[[], object], begin: int, folder: Path, log: Path, limit_s: float
) -> None:
    """Run the case and write its outcome; never returns."""
    try:
        resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        seconds = math.ceil(limit_s)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 2))
        os.chdir(folder)
        errors = os.open(log, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
        os.dup2(errors, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        faulthandler.enable(file=2)
        faulthandler.register(signal.SIGXCPU, file=2, chain=True)
        try:
            case()
            found = Outcome("works")
        except BaseException as error:
            found = of_error(error)
        os.write(begin, f"{found.kind}\n{found.text[:2000]}".encode(errors="replace"))
    finally:
        os._exit(0)


def _read(pipe: int, limit_s: float) -> tuple[bytes, bool]:
    deadline, said = time.monotonic() + limit_s, b""
    while True:
        ready, _, _ = select.select([pipe], [], [], max(0.0, deadline - time.monotonic()))
        if not ready:
            return said, False
        part = os.read(pipe, 1 << 16)
        if not part:
            return said, True
        said += part
