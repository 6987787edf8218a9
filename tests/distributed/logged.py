"""Tasks that leave a line in a log when they begin and when they end; importable by workers."""

import os
import time
from concurrent.futures import Executor
from pathlib import Path


def logged(log: str, function, arguments):
    _line(log, f"begin {os.getpid()}")
    time.sleep(0.03)  # so that a worker can be killed within a task
    result = function(*arguments)
    _line(log, f"end {os.getpid()}")
    return result


def _line(log: str, text: str) -> None:
    file = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(file, f"{text}\n".encode())
    os.close(file)


class Logged(Executor):
    """Another executor, whose workers log their tasks."""

    def __init__(self, executor, log: Path) -> None:
        self._executor, self._client, self.log = executor, executor._client, log
        self.submitted = 0

    def submit(self, function, /, *arguments):
        self.submitted += 1
        return self._executor.submit(logged, str(self.log), function, arguments)

    def lines(self) -> list[tuple[str, int]]:
        """("begin" or "end", process) in order."""
        text = self.log.read_text() if self.log.exists() else ""
        return [(word, int(pid)) for word, pid in map(str.split, text.splitlines())]
