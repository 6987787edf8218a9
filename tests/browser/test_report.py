"""The report in a real browser: Debian's chromium, headless, straight from disk."""

from __future__ import annotations

from pathlib import Path

import pytest
from devtools import Browser
from known_report import Report

pytestmark = pytest.mark.browser


def shown(tab: Browser, page: Report, fragment: str = "", setting: str = "s0") -> None:
    tab.open(page.path, fragment)
    tab.wait_for(f"document.documentElement.dataset.shown?.startsWith('{setting} ')")


def test_every_setting_is_a_point_in_both_plots_and_the_chosen_one_is_marked(
    tab: Browser, page: Report
) -> None:
    shown(tab, page, "select=s3", "s3")
    points = "[...document.querySelectorAll('#plot-{0} .point')].map(p => p.dataset.id)"
    for plot in ("total_s", "rays"):
        assert sorted(tab.eval(points.format(plot))) == [f"s{i}" for i in range(6)]
    chosen = "[...document.querySelectorAll('{0}.selected')].map(p => p.dataset.id)"
    assert tab.eval(chosen.format(".point")) == ["s3", "s3"]
    assert tab.eval(chosen.format("tr")) == ["s3"]
    assert tab.text("chosen") == "C_E = 8, C_N = 8, seed 0"


def test_settings_are_chosen_by_points_rows_and_arrow_keys(tab: Browser, page: Report) -> None:
    shown(tab, page)
    tab.eval(
        "document.querySelector('#plot-rays .point[data-id=s2]')"
        ".dispatchEvent(new MouseEvent('click', {bubbles: true}))"
    )
    tab.wait_for("document.documentElement.dataset.shown === 's2 signed'")
    tab.key("ArrowDown")
    tab.wait_for("document.documentElement.dataset.shown === 's3 signed'")
    tab.eval("document.querySelector('tr[data-id=s5]').focus()")
    tab.key("Enter")
    tab.wait_for("document.documentElement.dataset.shown === 's5 signed'")
    tab.wait_for("location.hash.startsWith('#select=s5&')")


def test_cells_of_a_heat_map_choose_settings_and_show_what_is_chosen(
    tab: Browser, page: Report
) -> None:
    shown(tab, page)
    cell = "document.querySelector('#heatmap-rays .cell[data-id=s3]')"
    tab.eval(f"{cell}.dispatchEvent(new MouseEvent('click', {{bubbles: true}}))")
    tab.wait_for("document.documentElement.dataset.shown === 's3 signed'")
    chosen = "[...document.querySelectorAll('.cell.selected')].map(c => c.dataset.id)"
    assert tab.eval(chosen) == ["s3", "s3"]
    tab.eval(f"{cell}.dispatchEvent(new MouseEvent('mousemove', {{clientX: 9, clientY: 9}}))")
    assert tab.text("hover") == "C_E = 8, C_N = 8"


def test_two_pictures_have_a_page_of_their_own(tab: Browser, page: Report, tmp_path: Path) -> None:
    from viscache import report

    alone = report.write_difference(
        page.pictures["s4"], page.reference, tmp_path / "p.html", name="a.exr"
    )
    tab.open(alone, "map=flip")
    tab.wait_for("document.documentElement.dataset.shown === 's0 flip'")
    assert tab.text("chosen") == "a.exr" and tab.eval("$('against').parentNode.hidden") is True
    assert tab.eval("document.getElementById('nomap').hidden") is True
    assert tab.eval("document.querySelectorAll('#settings td').length") == 8  # the metrics


def test_a_browser_that_cannot_unpack_pictures_is_told_and_has_the_rest(
    tab: Browser, page: Report
) -> None:
    old = tab.call("Page.addScriptToEvaluateOnNewDocument", source="delete DecompressionStream")
    tab.open(page.path, "select=s3")
    tab.call("Page.removeScriptToEvaluateOnNewDocument", **old)
    assert tab.eval("[$('viewer').hidden, $('nopictures').hidden]") == [True, False]
    assert "too old" in tab.text("nopictures") and tab.text("chosen").startswith("C_E = 8")


def test_a_sweep_without_pictures_has_a_page_that_works(tab: Browser, tmp_path: Path) -> None:
    import xarray

    from viscache import report

    cells = {n: (("c_e", "repeat"), [[2.0], [1.0]]) for n in ("rel_l1", "total_s", "rays")}
    given = {"scene": "room", "metrics": '["rel_l1"]', "size": "[8, 6]", "spp": 1}
    names = {"integrator": "direct", "visibility": "aqvc", "rays": "embree"}
    given |= {what: f'{{"name": "{name}"}}' for what, name in names.items()}
    given |= {"provenance": "{}", "scene_hash": "ab", "cpu": "c"}
    ds = xarray.Dataset(cells, {"c_e": [4, 8], "repeat": [0]}, given)
    tab.open(report.write(ds, tmp_path / "r.html"), "select=s1&zoom=3")
    assert tab.text("chosen") == "C_E = 8"
    tab.key("ArrowUp")
    assert tab.text("chosen") == "C_E = 4"
    assert tab.eval("[$('viewer').hidden, $('nopictures').hidden]") == [True, False]


def test_the_table_sorts_by_a_column(tab: Browser, page: Report) -> None:
    shown(tab, page)
    order = "[...document.querySelectorAll('#settings tbody tr')].map(r => r.dataset.id).join('')"
    assert tab.eval(order) == "s0s1s2s3s4s5"
    head = "document.querySelector('[data-column=rays] button').click()"
    tab.eval(head)
    assert tab.eval(order)[:2] in ("s4", "s5")  # few rays at the coarsest
    tab.eval(head)
    assert tab.eval(order)[:2] in ("s0", "s1")


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_a_phone_shows_all_without_scrolling_sideways(
    tab: Browser, page: Report, dark: bool
) -> None:
    tab.size(390, 844, phone=True, dark=dark)
    shown(tab, page)
    assert tab.eval("document.documentElement.scrollWidth") <= 390
    paper = tab.eval("getComputedStyle(document.body).backgroundColor")
    assert paper == ("rgb(22, 24, 27)" if dark else "rgb(251, 251, 250)")
    tab.eval("document.getElementById('theme').click()")
    assert tab.eval("getComputedStyle(document.body).backgroundColor") != paper


def test_everything_that_acts_has_a_name_and_is_reached_by_the_keyboard(
    tab: Browser, page: Report
) -> None:
    shown(tab, page)
    nameless = tab.eval("""[
      ...document.querySelectorAll('button, input, select, [tabindex], [role=img]')]
      .filter(e => !(e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim()))
      .map(e => e.outerHTML.slice(0, 80))""")
    assert nameless == []
    reached = set()
    for _ in range(60):
        tab.key("Tab")
        reached.add(tab.eval("document.activeElement.id || document.activeElement.dataset.id"))
    wanted = {"theme", "against", "ev", "more-zoom", "full", "stage", "wipe", "flip", "mapstage"}
    wanted |= {"kind", "gain", "s0", "s5"}
    assert wanted <= reached


def test_errors_of_the_script_and_requests_are_noticed(
    browser: Browser, page: Report, tmp_path: Path
) -> None:
    """The other tests rely on this: errors of the page and network requests are detected."""
    text, last = page.path.read_text("utf-8"), "readFragment(); show();\n"
    assert text.count(last) == 1
    for bad, complaint in (
        ("undefined_name();\n", "undefined_name"),
        ("new Image().src = 'http://127.0.0.1:9/x.png';\n", "x.png"),
    ):
        broken = tmp_path / "broken.html"
        head, _, tail = text.rpartition(last)
        broken.write_text(head + last + bad + tail, "utf-8")
        browser.errors.clear()
        browser.open(broken)
        browser.wait_for("document.documentElement.dataset.shown !== undefined")
        assert any(complaint in e for e in browser.errors)
    browser.errors.clear()
