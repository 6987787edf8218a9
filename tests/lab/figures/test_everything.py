"""`viscache reproduce all`: one page, resumable figure by figure, and its exit status."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from viscache import cli
from viscache.base import provenance
from viscache_lab import figures
from viscache_lab.experiment import Band, Experiment, Trial
from viscache_lab.experiment import run as everything
from viscache_lab.experiment.claim_rules import Claim

CALLS = []


@pytest.fixture
def two(monkeypatch):
    """Two figures, "holds" and "varies"; what they measure and raise can be changed."""
    for name in list(figures.FIGURES):
        monkeypatch.delitem(figures.FIGURES, name)
    state = {"measured": 3.0, "raises": None}
    CALLS.clear()

    def picture(folder, name):
        noise = np.random.default_rng(0).integers(0, 255, (600, 700, 3), dtype=np.uint8)
        Image.fromarray(noise).save(folder / f"{name}.png")
        return folder / f"{name}.png"

    def holds(trial):
        CALLS.append("holds")
        trial.row("a <b>", 1.0, printed=2.0)
        trial.row("fine", 1.0, band=Band(0.5, np.inf, "said so"))
        trial.files.append(picture(trial.folder, "holds"))
        trial.skip("far away", "absent")

    def varies(trial):
        CALLS.append("varies")
        if state["raises"] is not None:
            raise state["raises"]
        band = Band(2.5, 5.0, "Sec. 1: the paper", claimed=Claim(4.0, 5.0, "about"))
        trial.row("speed", state["measured"], printed=4, band=band)

    monkeypatch.setitem(figures.FIGURES, "holds", Experiment(description="one", function=holds))
    monkeypatch.setitem(figures.FIGURES, "varies", Experiment(description="two", function=varies))
    return state


class Page(HTMLParser):
    """The content of a page."""

    def __init__(self, text):
        super().__init__()
        self.ids: set[str] = set()
        self.links: set[str] = set()
        self.sources: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.ids |= {found["id"] or ""} if "id" in found else set()
        self.links |= {found["href"] or ""} if tag == "a" else set()
        self.sources += [found["src"] or ""] if tag == "img" else []

    def handle_data(self, data):
        self.text += data + "|"


def test_the_page_has_every_row_and_picture_and_needs_nothing_else(two, tmp_path):
    assert cli.main(["reproduce", "all", "-o", str(tmp_path), "--quick"]) == 0
    page = Page((tmp_path / "index.html").read_text())
    assert {"holds", "varies"} <= page.ids and {"#holds", "#varies"} <= page.links
    rows = ("a <b>", "speed", "0.5 … ∞", "2.5 … 5", "said so", "far away: absent")
    for words in (*rows, "2 figures and tables", "2 of 2 bands hold, 0 do not"):
        assert words in page.text.replace("|", ""), words
    assert "0.75" in page.text  # measured over printed
    claim = (
        "The paper's claim: not found (0 of 1). Our expectation: holds (1 of 1), at quick sizes."
    )
    for words in (claim, "|not found|", "|not found: 4 to 5 (about)|", "|not stated|"):
        assert words in page.text, words
    (source,) = page.sources
    assert source.startswith("data:image/webp;base64,") and len(source) < 1_000_000
    assert not re.search("https?:", (tmp_path / "index.html").read_text())


def test_a_band_that_fails_fails_the_command_and_is_named(two, tmp_path, capsys):
    two["measured"] = 2.0
    assert cli.main(["reproduce", "all", "-o", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "1 of 2 bands hold; 1 failures:" in out
    assert "varies: speed: 2 is not in 2.5 … 5" in out
    assert "found in 0 figures, not found in 1, not stated in 1, not judged" in out
    (missed,) = json.loads((tmp_path / "summary.json").read_text())["claims_not_found"]
    assert (missed["figure"], missed["measured"], missed["claim"]) == ("varies", 2.0, [4.0, 5.0])
    assert out.splitlines()[-1] == str(tmp_path / "index.html")
    assert "What does not hold" in Page((tmp_path / "index.html").read_text()).text


def test_a_figure_that_raises_fails_the_command_and_the_others_run(two, tmp_path, capsys):
    two["raises"] = RuntimeError("out of luck")
    assert cli.main(["reproduce", "all", "-o", str(tmp_path), "--json"]) == 1
    got = json.loads(capsys.readouterr().out)
    assert got["failing"] == [{"figure": "varies", "error": "RuntimeError: out of luck"}]
    assert got["claims"] == {"found": 0, "not_found": 0, "not_stated": 1, "not_judged": 0}
    assert got["figures"][1]["verdicts"] is None
    assert [f["figure"] for f in got["figures"]] == ["holds", "varies"]
    assert "out of luck" in (tmp_path / "index.html").read_text()
    two["raises"] = None  # what raised is tried again
    assert cli.main(["reproduce", "all", "-o", str(tmp_path)]) == 0
    assert CALLS == ["holds", "varies", "varies"]


def test_an_interrupted_run_goes_on_figure_by_figure(two, tmp_path, monkeypatch):
    two["raises"] = KeyboardInterrupt()
    words = ["reproduce", "all", "-o", str(tmp_path)]
    assert cli.main(words) == 130
    assert "holds" in Page((tmp_path / "index.html").read_text()).ids  # what there is so far
    two["raises"] = None
    assert cli.main(words) == 0 and CALLS == ["holds", "varies", "varies"]
    assert cli.main(words) == 0 and len(CALLS) == 3
    assert cli.main([*words, "--quick"]) == 0 and len(CALLS) == 5  # another size is another run
    (tmp_path / "holds.png").unlink()
    assert cli.main([*words, "--quick"]) == 0 and CALLS[5:] == ["holds"]
    monkeypatch.setattr(everything, "code_hash", lambda: "another")
    assert cli.main([*words, "--quick", "--older"]) == 0 and len(CALLS) == 6
    assert cli.main([*words, "--quick"]) == 0 and len(CALLS) == 8


def test_the_code_hash_is_of_the_sources():
    ours, every = provenance.code_hash(), everything.code_hash()
    assert len(ours) == len(every) == 64
    assert (ours, every) == (provenance.code_hash(), everything.code_hash())
    assert ours != every  # a change of a figure leaves the exact frames of sweeps as they are


def test_figures_of_one_folder_share_their_references(tmp_path):
    for name in ("one", "other"):
        frames = Trial(folder=tmp_path, options={"name": name}).exact_frames()
        assert frames.directory == tmp_path / "references"
