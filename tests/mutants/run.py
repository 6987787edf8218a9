"""Runs the mutants of `core.toml` and `package.toml`: each must make one of its tests fail.

    scripts/mutants [--only TEXT] [--list] [-j JOBS]

The sources are copied to `build/mutants/source`. There, all mutants of the core are built into one
module; the environment variable VISCACHE_MUTANT says which one runs. The released sources have no
trace of them. First, all tests must pass without a mutant.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
COPY = ROOT / "build" / "mutants" / "source"
SWITCH = "cpp/viscache/mutant.h"
HEADER = """#pragma once
// Written by scripts/mutants.
#include <cstdlib>
#include <string_view>

namespace viscache {
/// Whether this run is that of a mutant.
inline bool mutant(std::string_view name) {
    static const char* const chosen = std::getenv("VISCACHE_MUTANT");
    return chosen && name == chosen;
}
}  // namespace viscache
"""


@dataclass(frozen=True)
class Mutant:
    """One change of a source file that tests must notice."""

    name: str
    file: str
    text: str
    replacement: str
    tests: tuple[str, ...]
    statement: bool = False  #: an expression without a value

    @property
    def is_core(self) -> bool:
        """Whether it is built into the module."""
        return self.file.startswith("cpp/")

    def applied(self, source: str) -> str:
        """The source with this mutant; ValueError if its text does not stand there once."""
        found = source.count(self.text)
        if found != 1:
            raise ValueError(f"{self.name}: {self.file} must hold {self.text!r} once, got {found}")
        if not self.is_core:
            return source.replace(self.text, self.replacement)
        void = "(void)" if self.statement else ""
        chosen = f"viscache::mutant({json.dumps(self.name)})"
        return source.replace(
            self.text, f"({chosen} ? {void}({self.replacement}) : {void}({self.text}))"
        )


def catalogue() -> list[Mutant]:
    """All mutants, those of the core first."""
    found = []
    for file in ("core.toml", "package.toml"):
        table = tomllib.loads((HERE / file).read_text(encoding="utf-8"))
        found += [
            Mutant(**row | {"name": name, "tests": tuple(row["tests"])})
            for name, row in table.items()
        ]
    return found


def sources() -> list[str]:
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.splitlines()  # fmt: skip
    return [path for path in listed if (ROOT / path).is_file()]


def mutated_core(mutants: list[Mutant]) -> dict[str, bytes]:
    """Sources of the core with all of their mutants, and the switch."""
    made = {SWITCH: HEADER.encode()}
    for mutant in (m for m in mutants if m.is_core):
        source = made.get(mutant.file) or (ROOT / mutant.file).read_bytes()
        made[mutant.file] = mutant.applied(source.decode()).encode()
    for path in set(made) - {SWITCH}:
        text = made[path].decode()
        line = '#include "viscache/mutant.h"\n'
        after = "#pragma once\n" if path.endswith(".h") else ""
        made[path] = (text.replace(after, after + line, 1) if after else line + text).encode()
    return made


def copy(mutants: list[Mutant]) -> None:
    """Bring the copy up to date; what did not change keeps its time, so that little is compiled."""
    changed = mutated_core(mutants)
    for path in {*sources(), *changed}:
        content = changed[path] if path in changed else (ROOT / path).read_bytes()
        target = COPY / path
        if not target.exists() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            target.chmod(0o755 if os.access(ROOT / path, os.X_OK) else 0o644)


def build(jobs: int) -> None:
    log = COPY.parent / "build.log"
    with log.open("w") as output:
        for command in (
            ["cmake", "--preset", "dev"],
            ["cmake", "--build", "--preset", "dev", "-j", str(jobs)],
        ):
            if subprocess.run(command, cwd=COPY, stdout=output, stderr=output).returncode:
                sys.exit(f"the mutants do not build; see {log.relative_to(ROOT)}")


def pytest(tests: list[str], mutant: str = "") -> tuple[int, str]:
    """The status of tests in the copy (0: all passed, 1: some failed), and what failed."""
    environment = {**os.environ, "VISCACHE_MUTANT": mutant, "PYTHONPATH": "python"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--no-header"]
    command += [] if not mutant else ["-x"]
    done = subprocess.run(
        [*command, "-m", "not bench", *tests], cwd=COPY, env=environment,
        capture_output=True, text=True, errors="replace",
    )  # fmt: skip
    lines = done.stdout.strip().splitlines() or done.stderr.strip().splitlines() or [""]
    failed = [line for line in lines if line.startswith(("FAILED", "ERROR"))]
    return done.returncode, "; ".join([*failed[:3], lines[-1]])


def dies(mutant: Mutant) -> tuple[bool, str]:
    """Whether one of its tests fails, and what pytest said last."""
    tests = list(mutant.tests)
    if mutant.is_core:
        status, said = pytest(tests, mutant.name)
    else:
        path = COPY / mutant.file
        whole = path.read_text(encoding="utf-8")
        path.write_text(mutant.applied(whole), encoding="utf-8")
        try:
            status, said = pytest(tests, "of the package")
        finally:
            path.write_text(whole, encoding="utf-8")
    # Other states are errors of the run; a crash ends pytest by a signal, and is noticed, too
    return status == 1 or status < 0, said


def main() -> int:
    """Run them; 1 if one lives."""
    parser = argparse.ArgumentParser(description="every mutant must make one of its tests fail")
    parser.add_argument("--only", default="", help="those whose names contain this text")
    parser.add_argument("--list", action="store_true", help="print names and tests, run nothing")
    parser.add_argument("-j", type=int, default=2, dest="jobs", help="jobs of the build")
    arguments = parser.parse_args()
    every = catalogue()
    chosen = [m for m in every if arguments.only in m.name]
    if arguments.list:
        print("\n".join(f"{m.name}: {m.file}: {', '.join(m.tests)}" for m in chosen))
        return 0
    if not chosen:
        sys.exit(f"no mutant's name contains {arguments.only!r}")
    copy(every)
    build(arguments.jobs)
    status, said = pytest(sorted({test for m in chosen for test in m.tests}))
    print(f"without a mutant: {said}", flush=True)
    if status:
        sys.exit("the tests must pass without a mutant")
    living = []
    for mutant in chosen:
        begin = time.monotonic()
        dead, said = dies(mutant)
        seconds = time.monotonic() - begin
        print(f"{'dies ' if dead else 'LIVES'} {seconds:5.1f} s  {mutant.name}: {said}", flush=True)
        if not dead:
            living.append(mutant.name)
    print(f"{len(chosen) - len(living)} of {len(chosen)} mutants die")
    return 1 if living else 0


if __name__ == "__main__":
    sys.exit(main())
