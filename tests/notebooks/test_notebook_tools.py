"""The live film and the sliders of notebooks."""

import io
import threading
from typing import Any

import numpy as np
import PIL.Image
import pytest

import viscache as vc
from viscache.notebook import Film, sliders

pytest.importorskip("ipywidgets", reason="ipywidgets comes with the test extra")


class Handle:
    """Stands in for a cell's output."""

    def __init__(self):
        self.shown: list[bytes] = []

    def update(self, picture):
        self.shown.append(picture.data)


@pytest.fixture
def output(monkeypatch):
    display = pytest.importorskip("IPython.display", reason="IPython comes with the test extra")
    handle = Handle()

    def shows(picture, display_id):
        assert display_id
        handle.update(picture)
        return handle

    monkeypatch.setattr(display, "display", shows)
    return handle


def test_a_film_shows_a_frame_grow_and_ends_with_the_whole_of_it(output):
    scene = vc.scenes.room(triangles=2000)
    film = Film(exposure=1.0, refresh_s=0.0)
    frame = vc.tiles.render(scene, vc.Direct(), size=(140, 70), spp=16, parts=3, show=film)
    assert film.views == 3 == len(output.shown)
    assert len(set(output.shown)) == 3
    assert output.shown[-1] == vc.notebook.png(frame.image, 1.0)
    assert all(data[:4] == b"\x89PNG" for data in output.shown)


def test_a_film_that_is_not_to_refresh_often_shows_the_first_and_the_last(output):
    film = Film(refresh_s=60.0)
    frame = vc.Frame(layers={"color": np.ones((4, 4, 3))})
    for done in range(1, 9):
        film(frame, done, 8)
    assert film.views == 2
    with pytest.raises(ValueError, match="refresh_s must be >= 0, got -1"):
        Film(refresh_s=-1)


def test_a_png_shows_the_tone_mapped_picture_whatever_the_effort():
    picture = np.random.default_rng(0).uniform(0, 1.5, (9, 13, 3))
    wanted = vc.tonemap.to_srgb8(picture, 0.8)
    pngs = [vc.notebook.png(picture, 0.8)]
    pngs += [vc.tonemap.encode(wanted, effort=effort) for effort in (0, 6, 9)]
    for data in pngs:
        assert (np.asarray(PIL.Image.open(io.BytesIO(data))) == wanted).all()


def test_a_slider_that_moves_renders_again():
    asked = []

    def render(level, kind):
        asked.append((level, kind))
        return np.full((4, 6, 3), level / 10), f"{kind} {level}"

    view = sliders(render, level=[1, 2, 3], kind=["a", "b"], first={"level": 2}, exposure=1.0)
    before = view.picture.value
    view.widgets["level"].value = 3
    assert view.text == "a 3" and view.picture.value != before
    view.widgets["kind"].value = "b"
    assert asked == [(2, "a"), (3, "a"), (3, "b")] and len(view.milliseconds) == 3


def test_a_live_slider_leaves_out_moves_that_a_newer_one_overtook():
    asked = []
    begun, go_on = threading.Event(), threading.Event()

    def render(level):
        asked.append(level)
        if level == 1:
            begun.set()
            assert go_on.wait(60)
        return np.full((4, 6, 3), level / 10), f"level {level}"

    view = sliders(render, level=[0, 1, 2, 3, 4], exposure=1.0, live=True)
    slider = view.widgets["level"]
    assert slider.continuous_update and view.settle(0)
    slider.value = 1
    assert begun.wait(60) and not view.settle(0)
    for level in (2, 3, 4):  # while 1 is drawn
        slider.value = level
    go_on.set()
    assert view.settle(60)
    assert asked == [0, 1, 4] and view.text == "level 4"
    assert view.picture.value == vc.notebook.png(np.full((4, 6, 3), 0.4), 1.0)


def test_a_live_slider_tells_what_went_wrong_and_goes_on():
    def render(level):
        if level == 1:
            raise ValueError("level must be < 1")
        return np.ones((4, 6, 3)), f"level {level}"

    view = sliders(render, level=[0, 1, 2], live=True)
    view.widgets["level"].value = 1
    assert view.settle(60) and view._label.value == "ValueError: level must be &lt; 1"
    view.widgets["level"].value = 2
    assert view.settle(60) and view.text == "level 2"


@pytest.mark.parametrize(
    ("values", "first", "says"),
    [
        ({}, None, "there must be a slider"),
        ({"a": []}, None, "a must have values"),
        ({"a": [1]}, {"a": 2}, r"first of a must be one of \[1\], got 2"),
    ],
)
def test_sliders_without_values_are_refused(values, first, says):
    with pytest.raises(ValueError, match=says):
        sliders(lambda **_: (np.ones((2, 2, 3)), ""), first=first, **values)
