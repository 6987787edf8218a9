"""One family in a process of its own: `python -m viscache_lab.extremes.child FAMILY FD SKIP FULL`.

Writes a line of JSON to a file descriptor before and after each case, so that the parent knows
which case was running when the process crashed or was ended.
"""

from __future__ import annotations

import itertools
import json
import os
import resource
import sys
import time
from typing import Any

from viscache_lab.experiment import FAMILIES
from viscache_lab.extremes import families  # registers them
from viscache_lab.extremes.case import checked


def main(name: str, descriptor: int, skip: int, full: bool) -> None:
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
        limit = list(case.limit) if isinstance(case.limit, tuple) else case.limit
        tell(begins=case.name, limit=limit, why=case.why)
        start = time.process_time()
        check = checked(case)
        tell(check=check.as_dict(), cpu_s=time.process_time() - start)
    tell(end=True)


if __name__ == "__main__":
    assert families
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4] == "full")
