"""docs/performance/where.md has a row for every figure, with commands that exist; counts hold."""

import re
import shlex
from functools import cache

import pytest

from codebase.repository import text
from viscache import Aqvc, NeePlusPlus, Whitted, cli, metrics, render, scenes
from viscache_lab import bench as benches
from viscache_lab.figures import FIGURES
from viscache_lab.figures.aqvc_nee import discarded
from viscache_lab.figures.aqvc_runs import Shot
from viscache_lab.figures.aqvc_setups import SETUPS

PAGE, TOLERANCE = "docs/performance/where.md", 0.05
COLUMNS = 6
HEADINGS = ("README", "Which cache when", "Limits")


def rows(page, heading):
    section = re.split(r"^## ", page, flags=re.M)
    (found,) = [part for part in section if part.partition("\n")[0] == heading]
    lines = [line for line in found.splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    ruled = [n for n, row in enumerate(cells) if set("".join(row)) <= set("-: ")]
    heads = {*ruled, *(n - 1 for n in ruled)}
    return [row for n, row in enumerate(cells) if n not in heads]


def labels(page, heading):
    return [row[0] for row in rows(page, heading)]


def bare(words):
    """Without line ends and the marks of links and code."""
    return " ".join(re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", words).replace("`", "").split())


@pytest.mark.parametrize("heading", HEADINGS)
def test_every_row_is_complete_and_its_command_exists(heading):
    for row in rows(text(PAGE), heading):
        assert len(row) == COLUMNS and all(row), row
        _, frame, setting, chosen, command, _ = row
        assert frame != "–" and setting != "–" and chosen != "–"
        assert command.startswith("none: ") or all(map(exists, command.split("; ")))


def exists(command):
    """Whether a command of the page is one of viscache, or a script of the repository."""
    words = shlex.split(command.strip("`"))
    if words[0] != "viscache":
        return words[0] == "python" and bool(text(words[1]))
    cli._parser(words[1:]).parse_args(words[1:])
    known = {"reproduce": {*FIGURES, "all"}, "bench": {*benches.BENCHES, "list"}}
    return words[1] not in known or words[2] in known[words[1]]


def test_a_command_that_is_not_there_is_noticed():
    assert exists("`viscache bench aqvc-frame`") and exists("`python scripts/readme_picture.py`")
    assert not exists("`viscache bench aqvc-frames`") and not exists("`viscache reproduce vlf-x9`")


def test_few_rows_have_no_command():
    every = [row for heading in HEADINGS for row in rows(text(PAGE), heading)]
    assert sum(row[4].startswith("none") for row in every) <= 3 < len(every)


def test_every_row_of_which_cache_and_of_the_readme_is_there():
    named = set(labels(text(PAGE), "Which cache when"))
    pictures = labels(text("docs/which-cache.md"), "In short")
    assert len(pictures) >= 17 and set(pictures) <= named
    frames = [r for r in re.findall(r"^\| (\d+×\d+, [^|]*?) \|", text("README.md"), re.M)]
    assert len(frames) == 2 and set(frames) <= set(labels(text(PAGE), "README"))


def test_figures_of_limits_stand_there():
    page = bare(text("docs/limits.md"))
    named = [bare(label) for label in labels(text(PAGE), "Limits")]
    missing = [label for label in named if re.search(r"\d", label) and label not in page]
    assert missing == []


def test_a_page_without_a_row_is_noticed():
    page = text("docs/which-cache.md").replace("| ambient occlusion |", "| a new kind |")
    assert not set(labels(page, "In short")) <= set(labels(text(PAGE), "Which cache when"))


@cache
def counted(scene):
    """Percent of the connections: blocked, left out, and the rays of both caches."""
    size = (320, 200)
    shots = {
        "apartment": lambda: SETUPS["delta"].shot(False, size),
        "conference": lambda: SETUPS["conference"].shot(False, size),
        "room": lambda: Shot(scene=scenes.room(), integrator=Whitted(n_vpls=256), size=size),
    }
    shot = shots[scene]()
    exact, roulette = shot.frame(), shot.frame(NeePlusPlus())
    cached = shot.frame(Aqvc(c_e=12, exact_groups=()))
    return {
        "blocked": 100 * float(exact.counters["occluded"] / exact.counters["queries"]),
        "left out": 100 * discarded(roulette),
        "rays": 100 / roulette.counters["ray_reduction"],
        "cache": 100 / cached.counters["ray_reduction"],
    }


def close(said, measured):
    """Whether a percentage that a page says is the measured one, within 5 %."""
    return float(said.removesuffix(" %")) == pytest.approx(measured, rel=TOLERANCE)


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["apartment", "conference", "room"])
def test_counts_beside_next_event_estimation_are_those_of_the_page(scene):
    page = text("docs/performance/quantized-cache.md")
    table = rows(page, "Comparison with Next Event Estimation++")
    (row,) = [cells for cells in table if cells[0].startswith(scene) and len(cells) == 7]
    said = dict(zip(("blocked", "left out", "rays", "_", "cache"), row[1:6], strict=True))
    found = counted(scene)
    wrong = {what: (said[what], value) for what, value in found.items()}
    assert {what: pair for what, pair in wrong.items() if not close(*pair)} == {}


@pytest.mark.slow
def test_counts_of_which_cache_are_measured():
    (row,) = [r for r in rows(text("docs/which-cache.md"), "In short") if r[0] == "no bias allowed"]
    rays, blocked, more_rays, fewer = re.findall(r"\d+ %", row[3])
    apartment, room = counted("apartment"), counted("room")
    assert close(rays, apartment["rays"]) and close(blocked, apartment["blocked"])
    assert close(more_rays, room["rays"]) and close(fewer, room["blocked"])
    (named,) = [r for r in rows(text(PAGE), "Which cache when") if r[0] == "no bias allowed"]
    assert named[-1] == f"{rays}, {blocked}, {more_rays}, {fewer}"


@pytest.mark.release
def test_the_caption_at_the_head_is_measured():
    """As scripts/readme_picture.py renders it."""
    caption = text("README.md").splitlines()[2]
    said = re.search(r"with (\d+) queries per shadow ray and rel_l1 (\S+) %", caption)
    assert said is not None
    options = {"scene": scenes.room(), "integrator": Whitted(n_vpls=512)}
    options |= {"size": (480, 300), "spp": 16}
    exact, cached = render(**options), render(**options, visibility=Aqvc(c_e=16))
    error = 100 * metrics.compare(cached, exact, metrics=["rel_l1"])["rel_l1"]
    assert float(said[1]) == pytest.approx(cached.counters["ray_reduction"], rel=TOLERANCE)
    assert float(said[2]) == pytest.approx(error, rel=TOLERANCE)


def test_a_count_that_is_off_by_more_is_noticed():
    assert close("26 %", 25.8) and close("13 %", 12.7)
    assert not close("46 %", 33.6) and not close("26 %", 28.0)
