"""The README's program runs as printed (on a smaller room and picture)."""

import re
from pathlib import Path

import pytest

from codebase.repository import text


def program() -> str:
    (found,) = re.findall(r"```python\n(.*?)```", text("README.md"), re.S)
    return str(found)


def test_the_program_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    small = program().replace("200000", "2000").replace("(640, 400)", "(96, 64)")
    small = small.replace("n_vpls=256", "n_vpls=16")
    assert small.count("(96, 64)") == small.count("triangles=2000") == 1
    monkeypatch.chdir(tmp_path)
    exec(compile(small, "README.md", "exec"), {})
    reduction, error = map(float, capsys.readouterr().out.split())
    assert reduction > 1
    assert 0 <= error < 0.2
    assert (tmp_path / "room.exr").stat().st_size > 0


def test_the_program_of_the_readme_has_ten_lines() -> None:
    lines = [line for line in program().splitlines() if line.strip()]
    assert len(lines) <= 10
