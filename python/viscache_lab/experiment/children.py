"""Runs families in child processes: a crash or a hang is a failed check and ends nothing else.

A child is `python -m viscache_lab.experiment.children FAMILY DESCRIPTOR SKIP full|quick`. It writes
a line of JSON before and after each case, so that the parent knows which case was running when the
process crashed or was ended.
"""

from __future__ import annotations

import itertools
import json
import os
import resource
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

from viscache.base import provenance
from viscache.settings.checks import require
from viscache.settings.spelling import nearest
from viscache_lab.experiment.checks import Check, checked, unmeasured
from viscache_lab.experiment.registry import FAMILIES

#: The instruction sets of the kernels, from the plainest.
ISAS = ("portable", "avx2", "avx512")
#: Seconds that a case may take. In the default run none takes 10 s on one loaded core.
LIMIT_S, FULL_LIMIT_S = 120.0, 900.0
#: Seconds for a process to start: the imports, on a crowded machine.
START_S = 120.0
#: The process of a family.
CHILD = ("-m", "viscache_lab.experiment.children")

Told = Callable[[Check], None]


def instruction_sets() -> tuple[str, ...]:
    """Those that this CPU has."""
    return ISAS[: ISAS.index(provenance.isa()[1]) + 1]


def run(
    names: Iterable[str] | None = None,
    *,
    full: bool = False,
    workers: int | None = None,
    limit_s: float | None = None,
    told: Told | None = None,
) -> list[Check]:
    """The checks of families, all by default; ValueError gives the nearest to an unknown name.

    `full` has more and longer cases, and every family again for the lower instruction sets. There
    is one process per core by default, whose frames have one thread each. A case may take `limit_s`
    (120 s, or 900 s in full). `told` gets each check as soon as it is there.
    """
    FAMILIES.load()
    chosen = list(FAMILIES if names is None else names)
    for name in chosen:
        require(name in FAMILIES, f"family must be known{nearest(name, FAMILIES)}", name)
    active = provenance.isa()[0]
    others = [isa for isa in instruction_sets() if isa != active] if full else []
    jobs = [(name, "") for name in chosen]
    jobs += [(name, isa) for isa in others for name in chosen if FAMILIES[name].every_isa]
    limit = limit_s or (FULL_LIMIT_S if full else LIMIT_S)
    stop, lock = threading.Event(), threading.Lock()

    def measured(job: tuple[str, str]) -> list[Check]:
        found = []
        for check in _family(*job, full, limit, stop):
            found.append(check)
            if told is not None:
                with lock:
                    told(check)
        return found

    with ThreadPoolExecutor(workers or provenance.thread_count()) as pool:
        results = [pool.submit(measured, job) for job in jobs]
        try:
            return [check for result in results for check in result.result()]
        except BaseException:
            stop.set()
            for result in results:
                result.cancel()
            raise


def _family(
    name: str, isa: str, full: bool, limit_s: float, stop: threading.Event
) -> Iterator[Check]:
    """The checks of a family. After a crash or a hang, a new process goes on with the next case."""
    prefix = f"{isa}, {name}" if isa else name
    done = 0

    def of_family(check: Check, error: str = "") -> Check:
        error = error or check.error
        return replace(check, name=f"{prefix}: {check.name}", error=error, family=name, isa=isa)

    while not stop.is_set():
        child = _Child(name, isa, done, full)
        running: Check | None = None
        try:
            for message in child.messages(limit_s, stop):
                if "begins" in message:  # "ready" and "end" only show that it lives
                    running, done = Check.from_dict(message["begins"]), done + 1
                elif "check" in message:
                    running = None
                    yield of_family(Check.from_dict(message["check"]))
        finally:
            error = child.finish(stop)
        if running is None:
            if error:  # nothing to go on with
                yield of_family(_WHOLE, error)
            return
        yield of_family(running, error or "the process ended without an answer")


#: What a process that fails between cases has failed.
_WHOLE = Check(
    name="the process starts and ends by itself",
    value=None,
    limit=0,
    why="every process ends with status 0",
)


class _Child:
    """The process of one family, and what it tells."""

    def __init__(self, name: str, isa: str, skip: int, full: bool) -> None:
        self._read, write = os.pipe()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        self._hung = ""
        words = [name, str(write), str(skip), "full" if full else "quick"]
        environment = dict(os.environ, **({"VISCACHE_ISA": isa} if isa else {}))
        self._process = subprocess.Popen(
            [sys.executable, *CHILD, *words],
            pass_fds=[write],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
        )
        os.close(write)

    def messages(self, limit_s: float, stop: threading.Event) -> Iterator[dict[str, Any]]:
        """What the child says, until it ends or says nothing for `limit_s`."""
        text, deadline = b"", time.monotonic() + START_S
        while not stop.is_set():
            if not select.select([self._read], [], [], 0.2)[0]:
                if time.monotonic() > deadline:
                    self._hung = f"no answer within {limit_s:g} s"
                    return
                continue
            got = os.read(self._read, 1 << 16)
            if not got:
                return
            deadline = time.monotonic() + limit_s
            *lines, text = (text + got).split(b"\n")
            yield from map(json.loads, lines)

    def finish(self, stop: threading.Event) -> str:
        """Ends the process. Why it did not end well; empty if it did."""
        try:
            if not self._hung and not stop.is_set():
                self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._hung = "the process did not end"
        finally:
            self._process.kill()
            self._process.wait()
            os.close(self._read)
        self._errors.seek(0)
        last = self._errors.read().decode(errors="replace").strip().splitlines()[-1:]
        self._errors.close()
        status = self._process.returncode
        if self._hung or status == 0:
            return self._hung
        ended = signal.Signals(-status).name if status < 0 else f"status {status}"
        return ": ".join([f"ended by {ended}", *last])


def child(name: str, descriptor: int, skip: int, full: bool) -> None:
    """Measure the cases of a family from number `skip` on."""
    family = FAMILIES[name]
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a crash is reported, not stored
    if family.most_bytes is not None:
        most = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (family.most_bytes, most))

    def tell(**what: Any) -> None:
        os.write(descriptor, (json.dumps(what) + "\n").encode())

    tell(ready=True)
    for case in itertools.islice(family.function(full), skip, None):
        tell(begins=unmeasured(case).as_dict())
        start = time.process_time()
        check = replace(checked(case), cpu_s=time.process_time() - start)
        tell(check=check.as_dict())
    tell(end=True)


if __name__ == "__main__":
    FAMILIES.load()
    child(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4] == "full")
