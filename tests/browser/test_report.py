"""The report in a real browser: Debian's chromium, headless, straight from disk."""

import pytest

pytestmark = pytest.mark.browser


def shown(tab, page, fragment="", setting="s0"):
    tab.open(page.path, fragment if "select" in fragment else f"select={setting}&{fragment}")
    tab.wait_for(f"document.documentElement.dataset.shown?.startsWith('{setting} ')")


def test_every_setting_is_a_point_in_both_plots_and_the_chosen_one_is_marked(tab, page):
    shown(tab, page, "select=s3", "s3")
    points = "[...document.querySelectorAll('#plot-{0} .point')].map(p => p.dataset.id)"
    for plot in ("total_s", "rays"):
        assert sorted(tab.eval(points.format(plot))) == [f"s{i}" for i in range(6)]
    chosen = "[...document.querySelectorAll('{0}.selected')].map(p => p.dataset.id)"
    assert tab.eval(chosen.format(".point")) == ["s3", "s3"]
    assert tab.eval(chosen.format("tr")) == ["s3"]
    assert tab.text("chosen") == "C_E = 8, C_N = 8, seed 0"


def test_settings_are_chosen_by_points_rows_and_arrow_keys(tab, page):
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


def test_cells_of_a_heat_map_choose_settings_and_show_what_is_chosen(tab, page):
    shown(tab, page)
    cell = "document.querySelector('#heatmap-rays .cell[data-id=s3]')"
    tab.eval(f"{cell}.dispatchEvent(new MouseEvent('click', {{bubbles: true}}))")
    tab.wait_for("document.documentElement.dataset.shown === 's3 signed'")
    chosen = "[...document.querySelectorAll('.cell.selected')].map(c => c.dataset.id)"
    assert tab.eval(chosen) == ["s3", "s3"]
    tab.eval(f"{cell}.dispatchEvent(new MouseEvent('mousemove', {{clientX: 9, clientY: 9}}))")
    assert tab.text("hover") == "C_E = 8, C_N = 8"


def test_two_pictures_have_a_page_of_their_own(tab, page, tmp_path):
    from viscache import report

    alone = report.write_difference(
        page.pictures["s4"], page.reference, tmp_path / "p.html", name="a.exr"
    )
    tab.open(alone, "map=flip")
    tab.wait_for("document.documentElement.dataset.shown === 's0 flip'")
    assert tab.text("chosen") == "a.exr" and tab.eval("$('against').parentNode.hidden") is True
    assert tab.eval("document.getElementById('nomap').hidden") is True
    assert tab.eval("document.querySelectorAll('#settings td').length") == 8  # the metrics


def test_a_browser_that_cannot_unpack_pictures_is_told_and_has_the_rest(tab, page):
    old = tab.call("Page.addScriptToEvaluateOnNewDocument", source="delete DecompressionStream")
    tab.open(page.path, "select=s3")
    tab.call("Page.removeScriptToEvaluateOnNewDocument", **old)
    assert tab.eval("[$('viewer').hidden, $('nopictures').hidden]") == [True, False]
    assert "too old" in tab.text("nopictures") and tab.text("chosen").startswith("C_E = 8")


def test_a_sweep_without_pictures_has_a_page_that_works(tab, tmp_path):
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


def test_the_table_sorts_by_a_column(tab, page):
    shown(tab, page)
    order = "[...document.querySelectorAll('#settings tbody tr')].map(r => r.dataset.id).join('')"
    assert tab.eval(order) == "s0s1s2s3s4s5"
    head = "document.querySelector('[data-column=rays] button').click()"
    tab.eval(head)
    assert tab.eval(order)[:2] in ("s4", "s5")  # few rays at the coarsest
    tab.eval(head)
    assert tab.eval(order)[:2] in ("s0", "s1")


PHONE = (390, 844)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_a_phone_shows_all_without_scrolling_sideways(tab, page, dark):
    tab.size(*PHONE, phone=True, dark=dark)
    shown(tab, page)
    assert tab.eval("document.documentElement.scrollWidth") <= PHONE[0]
    paper = tab.eval("getComputedStyle(document.body).backgroundColor")
    assert paper == ("rgb(22, 24, 27)" if dark else "rgb(251, 251, 250)")
    tab.eval("document.getElementById('theme').click()")
    assert tab.eval("getComputedStyle(document.body).backgroundColor") != paper


def test_a_phone_shows_plots_in_letters_that_can_be_read(tab, page):
    tab.size(*PHONE, phone=True)
    shown(tab, page)
    sizes = tab.eval("""[...document.querySelectorAll('svg.plot')].map(plot =>
      Math.min(...[...plot.querySelectorAll('text')].map(t => parseFloat(
        getComputedStyle(t).fontSize) * plot.clientWidth / plot.viewBox.baseVal.width)))""")
    assert len(sizes) == 4 and min(sizes) >= 9.5
    overlap = tab.eval("""[$('plot-total_s'), $('plot-rays')].flatMap(plot => {
      const boxes = [...plot.querySelectorAll('.tick[text-anchor=middle]')]
        .map(t => t.getBoundingClientRect());
      return boxes.slice(1).map((b, i) => b.left - boxes[i].right);
    })""")
    assert overlap and min(overlap) > 2


def test_a_finger_beside_a_point_chooses_it(tab, page):
    tab.size(*PHONE, phone=True)
    shown(tab, page)
    point = "document.querySelector('#plot-rays .point[data-id=s4]')"
    tab.eval(f"{point}.scrollIntoView({{block: 'center'}})")
    x, y, width = tab.eval(f"(b => [b.left, b.top, b.width])({point}.getBoundingClientRect())")
    for kind in ("mousePressed", "mouseReleased"):
        tab.mouse(kind, x - 0.5 * width, y - 0.3 * width, button="left", clickCount=1)
    tab.wait_for("document.documentElement.dataset.shown.startsWith('s4 ')")


#: WCAG 2.1 contrast of every visible text to the colour behind it.
CONTRAST = """(() => {
  const rgb = css => (css.match(/[\\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
  const channel = v => (v /= 255) <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4;
  const light = c => .2126 * channel(c[0]) + .7152 * channel(c[1]) + .0722 * channel(c[2]);
  const behind = e => { for (; e; e = e.parentElement) {
    const c = rgb(getComputedStyle(e).backgroundColor); if (c.length < 4 || c[3] > 0.9) return c; }
    return rgb(getComputedStyle(document.body).backgroundColor); };
  const found = [];
  for (const e of document.querySelectorAll('main *')) {
    const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
    if (!own || !e.getClientRects().length) continue;
    if (e.closest('.stage, .cell, option, :disabled')) continue;
    const style = getComputedStyle(e);
    const ink = rgb(e instanceof SVGElement ? style.fill : style.color);
    const [a, b] = [light(ink), light(behind(e))].sort((x, y) => y - x);
    found.push([(a + .05) / (b + .05), e.textContent.slice(0, 30)]);
  }
  return found.sort((x, y) => x[0] - y[0]);
})()"""


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_every_text_stands_out_from_its_ground(tab, page, dark):
    tab.size(1200, 1000, dark=dark)
    shown(tab, page)
    found = tab.eval(CONTRAST)
    assert len(found) > 50 and found[0][0] >= 4.5, found[:5]


def test_the_verdict_comes_first_and_its_settings_are_chosen_by_a_click(tab, page):
    shown(tab, page)
    assert tab.eval("document.querySelector('header').nextElementSibling.className") == "verdict"
    first = tab.eval("document.querySelector('.verdict .first').textContent")
    assert first.startswith(
        "No setting has 1 % error: the smallest is 4 %, at C E = 4".replace("C E", "CE")
    )
    told = tab.eval("document.querySelector('.verdict').textContent")
    assert "rel_l1 (L\u0302INF)" in told
    last = "[...document.querySelectorAll('.choose')].at(-1)"
    tab.eval(f"{last}.click()")
    tab.wait_for(f"document.documentElement.dataset.shown === {last}.dataset.id + ' signed'")
    assert tab.eval(f"{last}.dataset.id") != "s0"
    assert tab.eval(f"{last}.getAttribute('aria-pressed')") == "true"


def test_provenance_is_folded_at_the_bottom(tab, page):
    shown(tab, page)
    facts = "document.querySelector('dl.facts').closest('details')"
    assert tab.eval(f"{facts}.open") is False
    assert (
        tab.eval(f"{facts}.compareDocumentPosition($('settings'))") == 2
    )  # the table is before it
    assert "Scene hash" in tab.eval(f"{facts}.textContent")


def test_the_page_opens_on_the_setting_for_its_target(tab, page, tmp_path):
    from viscache import report

    written = report.write(page.directory, tmp_path / "r.html", target=0.1, flip_maps=0)
    tab.open(written)
    tab.wait_for("document.documentElement.dataset.shown !== undefined")
    assert tab.text("chosen").startswith("C_E = 8")  # the cheapest of at most 10 %


def focused(tab):
    return str(
        tab.eval(
            "(e => e.id || e.closest('svg')?.id || e.closest('[id]')?.id || e.tagName)"
            "(document.activeElement)"
        )
    )


def test_everything_that_acts_has_a_name_and_is_reached_by_few_tabs(tab, page):
    shown(tab, page)
    nameless = tab.eval("""[
      ...document.querySelectorAll('button, input, select, [tabindex], [role=img], [role=radio]')]
      .filter(e => !(e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim()))
      .map(e => e.outerHTML.slice(0, 80))""")
    assert nameless == []
    stops = []
    for _ in range(40):
        tab.key("Tab")
        stops.append(focused(tab))
        if stops[-1] == "BODY":
            break
    wanted = {"theme", "against", "ev", "more-zoom", "full", "stage", "wipe", "flip", "mapstage"}
    wanted |= {"kind", "gain", "plot-total_s", "plot-rays", "heatmap-rays", "settings"}
    assert wanted <= set(stops)
    for group in ("plot-total_s", "plot-rays", "heatmap-rays"):
        assert stops.count(group) == 1
    assert stops.count("settings") == 2  # the head and a row
    assert stops[-1] == "BODY" and len(stops) <= 30


def test_arrow_keys_move_within_plots_and_the_table(tab, page):
    shown(tab, page, "select=s0")
    order = tab.eval("[...document.querySelectorAll('#plot-rays .point')].map(p => p.dataset.id)")
    tab.eval("document.querySelector('#plot-rays .point[tabindex=\"0\"]').focus()")
    assert tab.eval("document.activeElement.dataset.id") == "s0"
    tab.key("Home")
    assert tab.eval("document.activeElement.dataset.id") == order[0]
    for key, at in (("ArrowRight", 1), ("ArrowDown", 2), ("ArrowLeft", 1), ("End", 5)):
        tab.key(key)
        assert tab.eval("document.activeElement.dataset.id") == order[at]
        tab.wait_for(f"document.documentElement.dataset.shown === '{order[at]} signed'")
    assert tab.eval("document.activeElement.getAttribute('aria-checked')") == "true"
    # A heat map has two directions: columns are C_E, rows C_N
    tab.eval("document.querySelector('#heatmap-rays .cell[data-id=s0]').focus()")
    for key, setting in (("ArrowRight", "s2"), ("ArrowUp", "s3"), ("ArrowDown", "s2")):
        tab.key(key)
        assert tab.eval("document.activeElement.dataset.id") == setting
    tab.eval("document.querySelector('#settings tr[data-id=s2]').focus()")
    tab.key("ArrowDown")
    assert tab.eval("document.activeElement.dataset.id") == "s3"
    tab.eval("document.querySelector('#settings thead button').focus()")
    tab.key("ArrowRight")
    tab.key("Enter")
    assert tab.eval("document.querySelectorAll('#settings th')[1].ariaSort") == "ascending"


def test_errors_of_the_script_and_requests_are_noticed(browser, page, tmp_path):
    """The other tests rely on this: errors of the page and network requests are detected."""
    text, last = page.path.read_text("utf-8"), "readFragment(); show();\n"
    assert text.count(last) == 1
    for bad, complaint in (
        ("undefined_name();\n", "undefined_name"),
        ("new Image().src = 'http://127.0.0.1:9/x.png';\n", "x.png"),
        ("console.log('a word');\n", "a word"),
    ):
        broken = tmp_path / "broken.html"
        head, _, tail = text.rpartition(last)
        broken.write_text(head + last + bad + tail, "utf-8")
        browser.errors.clear()
        browser.open(broken)
        browser.wait_for("document.documentElement.dataset.shown !== undefined")
        assert any(complaint in e for e in browser.errors)
    browser.errors.clear()
