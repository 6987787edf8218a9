"""The report's difference viewer: the screen shows the radiance of the store."""

import re

import numpy as np
import pytest
from known_report import HEIGHT, WIDTH

from reference import report_pictures as packed
from viscache import metrics
from viscache.base import tonemap

pytestmark = pytest.mark.browser


@pytest.fixture
def data(page):
    return packed.model(page.path.read_text("utf-8"))


def shown(tab, page, fragment="", setting="s4", kind="signed"):
    tab.open(page.path, f"select={setting}&{fragment}")
    wait(tab, setting, kind)


def wait(tab, setting, kind):
    tab.wait_for(f"document.documentElement.dataset.shown === '{setting} {kind}'")
    tab.eval("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def tones(page, image, ev=0.0):
    """A picture, tone-mapped in Python."""
    exposure = tonemap.display_exposure(page.reference)
    return tonemap.to_srgb8(image, exposure * 2**ev).astype(int)


def at(pixels, u, v):
    """Colours at shares of a screenshot of a stage."""
    h, w = pixels.shape[:2]
    return pixels[(v * h).astype(int)[:, None], (u * w).astype(int)[None, :]]


def expected(picture, u, v, zoom=1.0, x=0.5, y=0.5):
    """Colours that a view has at shares of its stage."""
    columns = ((x + (u - 0.5) / zoom) * WIDTH).astype(int)
    rows = ((y + (v - 0.5) / zoom) * HEIGHT).astype(int)
    return picture[rows[:, None], columns[None, :]]


def middles(n, zoom, centre, size):
    """Positions on the stage, as shares, at pixel centres and away from tags and the grip."""
    first, last = (centre - 0.5 / zoom) * size, (centre + 0.5 / zoom) * size
    pixels = np.unique(np.linspace(first + 1, last - 2, n).astype(int)) + 0.5
    shares = (pixels / size - centre) * zoom + 0.5
    return shares[(np.abs(shares - 0.5) > 0.06) & (shares > 0.12) & (shares < 0.9)]


def signed_map(page, data, setting, gain):
    """Colours of the signed map, from the store's radiance."""
    delta = tonemap.luminance(page.pictures[setting]) - tonemap.luminance(page.reference)
    share = np.clip(0.5 + 0.5 * gain * delta * tonemap.display_exposure(page.reference), 0, 1)
    return packed.colors(data, "signed")[np.round(255 * share).astype(int)]


def check(stage, picture, within, zoom=1.0, x=0.5, y=0.5):
    u, v = middles(12, zoom, x, WIDTH), middles(9, zoom, y, HEIGHT)
    assert len(u) > 2 and len(v) > 2
    off = np.abs(at(stage, u, v) - expected(picture, u, v, zoom, x, y))
    assert off.max() <= within


@pytest.mark.parametrize("view", [(1.0, 0.5, 0.5), (4.0, 0.3, 0.6), (2.0, 0.75, 0.25)])
def test_all_stages_show_the_region_that_the_address_says(tab, page, data, view):
    place = "zoom={}&x={}&y={}".format(*view)
    reference, picture = tones(page, page.reference), tones(page, page.pictures["s4"])
    shown(tab, page, f"wipe=0&{place}")
    check(tab.screenshot("stage"), reference, 2, *view)
    check(tab.screenshot("mapstage"), signed_map(page, data, "s4", 16), 6, *view)
    shown(tab, page, f"wipe=1&{place}")
    check(tab.screenshot("stage"), picture, 2, *view)
    with pytest.raises(AssertionError):  # a region next to it is told from it
        check(tab.screenshot("stage"), picture, 2, view[0], view[1] + 0.04, view[2])


def test_zoomed_pixels_are_sharp(tab, page):
    shown(tab, page, "wipe=1&zoom=8&x=0.3&y=0.3")
    row = tab.screenshot("stage")[40, 90:190]  # some 68 screen pixels for one of the picture
    assert len(np.unique(row, axis=0)) <= 3


def test_the_wipe_shows_the_picture_on_its_left_and_the_reference_on_its_right(tab, page):
    reference, picture = tones(page, page.reference), tones(page, page.pictures["s4"])
    for share in (0.25, 0.75):
        shown(tab, page, f"wipe={share}")
        stage = tab.screenshot("stage")
        u, v = middles(30, 1, 0.5, WIDTH), middles(9, 1, 0.5, HEIGHT)
        u = u[np.abs(u - share) > 0.05]
        off_a, off_b = (
            np.abs(at(stage, u, v) - expected(p, u, v)).max((0, 2)) for p in (picture, reference)
        )
        assert off_a[u < share].max() <= 2 and off_b[u > share].max() <= 2
        assert off_a[u > share].max() > 4 and off_b[u < share].max() > 4


def test_the_grip_wipes_and_does_not_pan(tab, page):
    shown(tab, page, "zoom=4&x=0.5&y=0.5&wipe=0.5")
    left, top, width, height = tab.box("stage")
    middle = top + height / 2
    tab.drag((left + width / 2, middle), (left + width / 4, middle))
    assert tab.eval("[state.wipe, view.x, view.zoom]") == [pytest.approx(0.25, abs=0.01), 0.5, 4]
    tab.eval("document.getElementById('wipe').focus()")
    tab.key("ArrowRight")
    assert tab.eval("state.wipe") > 0.25 - 0.01


def test_the_flip_shows_the_reference_alone(tab, page):
    reference, picture = tones(page, page.reference), tones(page, page.pictures["s4"])
    shown(tab, page, "wipe=1")
    tab.key("f")
    assert tab.eval("document.getElementById('flip').getAttribute('aria-pressed')") == "true"
    check(tab.screenshot("stage"), reference, 2)
    tab.wait_for("location.hash.includes('flip=1')")
    tab.key("F")
    check(tab.screenshot("stage"), picture, 2)


def test_the_wheel_zooms_about_the_pointer(tab, page):
    shown(tab, page, "wipe=1")
    left, top, width, height = tab.box("mapstage")
    x, y = left + 0.25 * width, top + 0.7 * height
    before = tab.eval("view.under(0.25, 0.7)")
    for _ in range(2):
        tab.mouse("mouseWheel", x, y, deltaX=0, deltaY=-240)
    tab.wait_for("view.zoom === 4")
    assert tab.eval("view.under(0.25, 0.7)") == pytest.approx(before, abs=0.005)
    tab.wait_for("location.hash.includes('zoom=4')")
    zoom, u, v = (
        float(re.search(rf"[#&]{n}=([\d.]+)", tab.eval("location.hash"))[1])
        for n in ("zoom", "x", "y")
    )
    check(tab.screenshot("stage"), tones(page, page.pictures["s4"]), 2, zoom, u, v)


def test_the_page_scrolls_under_a_wheel_that_has_nothing_to_zoom_out_of(tab, page):
    shown(tab, page)
    left, top, width, height = tab.box("stage")
    before = tab.eval("scrollY")
    tab.mouse("mouseWheel", left + width / 2, top + height / 3, deltaX=0, deltaY=120)
    tab.wait_for(f"scrollY > {before}")
    assert tab.eval("view.zoom") == 1


def test_dragging_pans_all_stages_and_a_double_click_resets(tab, page):
    shown(tab, page, "zoom=4&x=0.5&y=0.5&wipe=1")
    left, top, width, height = tab.box("mapstage")
    tab.drag((left + 0.5 * width, top + 0.5 * height), (left + 0.75 * width, top + 0.25 * height))
    x, y = tab.eval("[view.x, view.y]")
    assert (x, y) == pytest.approx((0.4375, 0.5625), abs=0.002)
    check(tab.screenshot("stage"), tones(page, page.pictures["s4"]), 2, 4.0, x, y)
    left, top, width, height = tab.box("mapstage")
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            tab.mouse(kind, left + 50, top + 50, button="left", clickCount=count)
    assert tab.eval("[view.zoom, view.x, view.y]") == [1, 0.5, 0.5]


def test_two_fingers_pinch(tab, page):
    tab.size(390, 844, phone=True)
    shown(tab, page)
    left, top, width, height = tab.box("stage")
    middle, centre = top + height / 2, left + width / 2

    def fingers(kind, apart):
        points = [
            {"x": centre + side * apart / 2, "y": middle - 40, "id": i}
            for i, side in enumerate((-1, 1))
        ]
        tab.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)

    fingers("touchStart", 60)
    for apart in (80, 100, 120, 150, 180):
        fingers("touchMove", apart)
    tab.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    assert 2.2 < tab.eval("view.zoom") < 3.2
    assert tab.eval("view.x") == pytest.approx(0.5, abs=0.03)


def test_keys_zoom_move_and_fit(tab, page):
    shown(tab, page)
    tab.key("+")
    tab.key("+")
    assert tab.eval("view.zoom") == 4 and tab.text("zoomed") == "4×"
    tab.key("ArrowRight", shift=True)
    assert tab.eval("[view.x, view.y]") == pytest.approx([0.5 + 0.125 / 4, 0.5])
    tab.key("-")
    assert tab.eval("view.zoom") == 2
    tab.key("0")
    assert tab.eval("[view.zoom, view.x]") == [1, 0.5]
    assert tab.eval("document.getElementById('fit').disabled") is True


def test_the_view_stays_inside_the_picture(tab, page):
    shown(tab, page, "zoom=4&x=0&y=1")
    assert tab.eval("[view.x, view.y]") == [0.125, 0.875]
    shown(tab, page, "zoom=9999&x=0.5&y=oops")
    assert tab.eval("[view.zoom, view.y]") == [WIDTH / 4, 0.5]


def test_an_address_that_changes_is_followed(tab, page):
    shown(tab, page, "zoom=4&x=0.3&y=0.6&flip=1&ev=2&map=absolute", kind="absolute")
    tab.eval("location.hash = '#select=s2&wipe=0.8&zoom=2&x=0.3&y=0.4'")
    wait(tab, "s2", "signed")  # values that a link omits keep their defaults
    assert tab.eval("[view.zoom, view.x, view.y, state.wipe, state.flip, state.ev]") == [
        2,
        0.3,
        0.4,
        0.8,
        False,
        0,
    ]


def test_maps_are_switched_by_menu_key_and_address(tab, page, data):
    shown(tab, page)
    check(tab.screenshot("mapstage"), signed_map(page, data, "s4", 16), 6)
    tab.eval("(k => { k.value = 'absolute'; k.dispatchEvent(new Event('change')) })(kind)")
    wait(tab, "s4", "absolute")
    delta = np.abs(page.pictures["s4"].astype(float) - page.reference)
    colors, white = packed.colors(data, "error"), data["white"]
    share = np.clip(16 * delta.mean(2) / white, 0, 1)
    check(tab.screenshot("mapstage"), colors[np.round(255 * share).astype(int)], 6)
    tab.key("m")
    wait(tab, "s4", "relative")
    share = 0.16 / (1 + 0.01 * page.reference.mean() / page.reference.mean(2))
    share = np.clip(share * 2, 0, 1)
    tab.eval("change({gain: 2})")
    wait(tab, "s4", "relative")
    check(tab.screenshot("mapstage"), colors[np.round(255 * share).astype(int)], 6)
    assert tab.text("ticks") == "012.52537.550" and "[%]" in tab.text("unit")
    middle = tab.eval("parseFloat($('read-map').textContent)")
    assert middle == pytest.approx(16, rel=0.02)  # percent
    tab.wait_for("location.hash.includes('map=relative') && location.hash.includes('gain=2')")


def test_the_flip_map_is_the_evaluators_with_its_mean_in_the_caption(tab, page, data):
    errors, mean = metrics.flip_map(page.pictures["s4"].astype(float), page.reference.astype(float))
    shown(tab, page, "map=flip", kind="flip")
    colors = packed.colors(data, "flip")[np.round(255 * errors).astype(int)]
    check(tab.screenshot("mapstage"), colors, 6)
    assert f"mean {float(f'{mean:.3g}')}" in tab.text("caption")
    assert tab.text("ticks") == "00.250.50.751" and tab.text("unit") == "HDR-FLIP [0 to 1]"
    without = next(s["id"] for s in data["settings"] if "flip" not in s)
    assert tab.eval("document.getElementById('nomap').hidden") is True
    shown(tab, page, "map=flip", without, "flip")
    assert tab.eval("document.getElementById('nomap').hidden") is False


def test_the_gain_sets_a_scale_symmetric_about_zero(tab, page, data):
    for gain in (16, 4):
        shown(tab, page, f"gain={gain}")
        texts = tab.eval("[...ticks.children].map(t => t.textContent.replace('−', '-'))")
        low, _, zero, _, high = (float(t) for t in texts)
        assert zero == 0 and low == -high == pytest.approx(-data["white"] / gain, rel=5e-3)
        check(tab.screenshot("mapstage"), signed_map(page, data, "s4", gain), 6)


def test_the_read_out_is_the_stores_radiance_under_the_pointer(tab, page):
    shown(tab, page)
    left, top, width, height = tab.box("stage")
    column, row = 12, 33
    x, y = left + (column + 0.5) / WIDTH * width, top + (row + 0.5) / HEIGHT * height
    tab.mouse("mouseMoved", x, y)
    assert tab.text("read-place") == f"x {column}, y {row}"
    a, b = page.pictures["s4"][row, column].astype(float), page.reference[row, column].astype(float)
    for name, true in (("picture", a), ("reference", b), ("difference", a - b)):
        cells = f"[...document.getElementById('read-{name}').cells].slice(1)"
        read = tab.eval(f"{cells}.map(c => parseFloat(c.textContent.replace('−', '-')))")
        assert read == pytest.approx(true, rel=0.01 if name == "difference" else 0.0055)


def test_exposure_scales_radiance_before_the_curve(tab, page):
    shown(tab, page, "wipe=1&ev=-1")
    check(tab.screenshot("stage"), tones(page, page.pictures["s4"], -1), 2)
    tab.key("e")
    tab.key("e")
    check(tab.screenshot("stage"), tones(page, page.pictures["s4"], 0), 2)


def test_a_picture_is_compared_with_another_setting(tab, page, data):
    shown(tab, page, "wipe=0&against=s0&gain=8")
    check(tab.screenshot("stage"), tones(page, page.pictures["s0"]), 2)
    assert tab.text("right") == "C_E = 4, C_N = 4"
    delta = tonemap.luminance(page.pictures["s4"]) - tonemap.luminance(page.pictures["s0"])
    share = np.clip(0.5 + 4 * delta / data["white"], 0, 1)
    colors = packed.colors(data, "signed")[np.round(255 * share).astype(int)]
    check(tab.screenshot("mapstage"), colors, 6)


def test_what_is_no_number_is_magenta(tab, page):
    shown(tab, page)
    assert tab.eval(
        "(o => { paintPicture(o, [0x7e00, 0, 0, 15360, 15360, -15360], 0);"
        " return [...o] })(new Uint8ClampedArray(8))"
    ) == [255, 0, 255, 255, 255, 255, 0, 255]
    assert tab.eval(
        "(o => { paintMap(o, [NaN], [0, 1], colors.flip); return [...o] })"
        "(new Uint8ClampedArray(4))"
    ) == [255, 0, 255, 255]


def test_pixels_that_are_large_enough_have_their_values_written_into_them(tab, page):
    shown(tab, page, "zoom=4")
    assert tab.eval("document.querySelector('#stage .numbers').width") == 0
    shown(tab, page, "zoom=16")
    ink = (
        "(c => [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data]"
        ".filter((v, i) => i % 4 === 3 && v).length)"
        "(document.querySelector('#{} .numbers'))"
    )
    assert tab.eval(ink.format("stage")) > 1000 and tab.eval(ink.format("mapstage")) > 300
