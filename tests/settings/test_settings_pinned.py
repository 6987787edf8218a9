"""Names and defaults of the Python dataclasses are those of the C++ structs."""

import inspect

import numpy as np
import pytest

import viscache as vc
from viscache import _core


def test_whitted_lights_of_its_own_reach_the_core():
    own = vc.Vpls([(0, 3, 0)] * 3, [(0, -1, 0)] * 3, [1, 2, 3])
    assert vc.Whitted(vpls=own).core().vpls == 3 and vc.Whitted().core().vpls is None


def test_the_quantized_cache_has_the_names_and_defaults_of_its_struct():
    struct = _core.aqvc.AqvcParameters()
    rows = {row["name"]: getattr(struct, row["name"]) for row in struct.parameter_rows()}
    assert vc.Aqvc().resolved() == rows | {"preset": "default"}


def test_render_has_the_defaults_of_the_frame_struct():
    rows = _core.FrameSettings.parameter_rows()
    struct = {r["name"]: getattr(_core.FrameSettings(), r["name"]) for r in rows}
    defaults = {n: p.default for n, p in inspect.signature(vc.render).parameters.items()}
    same = ("spp", "seed", "first_sample")
    audit = {"audit_pixels": 0, "audit_share": 0}  # none; the classes have their own defaults
    assert {name: struct.pop(name) for name in audit} == audit
    assert struct.pop("audit_above") == vc.AuditQueries().above
    assert set(struct) == {"width", "height", "threads", "part", "parts", *same}
    assert (struct["part"], struct["parts"]) == (0, 1)  # all of it; `render_part` takes others
    assert [struct[name] for name in same] == [defaults[name] for name in same]
    assert struct["threads"] == 0 and defaults["threads"] is None  # both mean all
    camera = vc.look_at((0, 0, 1), (0, 0, 0))
    assert (camera.width, camera.height) == (struct["width"], struct["height"])


BAD = [
    (vc.Whitted, {"n_vpls": 1.5}, "n_vpls must be a whole number, got 1.5"),
    (vc.Whitted, {"n_vpls": True}, "n_vpls must be a whole number, got True"),
    (vc.Whitted, {"n_vpls": None}, "n_vpls must be a whole number, got None"),
    (vc.Whitted, {"vpl_bound": float("nan")}, "vpl_bound must be a finite number, got nan"),
    (vc.Whitted, {"vpl_bound": "0"}, "vpl_bound must be a finite number, got '0'"),
    (vc.Direct, {"points": "last"}, "points must be"),
    (vc.Direct, {"interleave": 2}, 'interleave must be 1 without environment="shared", got 2'),
    (vc.Whitted, {"environment": "shared", "interleave": 17}, "at most n_environment, got 17"),
    (vc.Whitted, {"environment": "product"}, 'environment must be "mis" or "shared"'),
    (vc.Whitted, {"vpls": [1]}, r"vpls must be vc.Vpls\(...\)"),
    (vc.AmbientOcclusion, {"n_samples": 64, "directions": "shared"}, "e.g. 513, with shared"),
    (vc.ShadowMap, {"max_bytes": 1 << 64}, r"max_bytes must be in \[1, 2\^64\), got 18446744073"),
    (vc.ShadowMap, {"vpls": 1}, "vpls must be true or false"),
    (vc.NeePlusPlus, {"symmetric": 1}, "symmetric must be true or false"),
    (vc.VisMaps, {"alpha": "two"}, "alpha must be one of"),
    (vc.VisMaps, {"alpha": "oracle"}, "viscache_lab.cases.simulation alone has"),
    (vc.VisMaps, {"alpha": True}, "alpha must be"),
    (vc.VisMaps, {"first_alpha": "zero"}, 'first_alpha must be "pilot" or "one"'),
    (vc.VisMaps, {"sampling": "other"}, "sampling must be"),
    (vc.VisMaps, {"cache": 3}, "cache must be"),
    (vc.VisMaps, {"criterion": "ambient"}, "criterion must be"),
    (vc.MapSettings, {"removal": "worst"}, 'k_worst must be > 0 with removal="worst", got 0'),
    (vc.MapSettings, {"weight_test": "half"}, "weight_test must be one of"),
    (vc.Direct, {"n_area": "4"}, "n_area must be a whole number"),
    (vc.AmbientOcclusion, {"distribution": 1}, "distribution must be"),
    (vc.AmbientOcclusion, {"max_distance": 0}, "max_distance must be > 0, .* None for no limit"),
    (vc.Embree, {"robust": "maybe"}, "robust must be true or false"),
    (vc.Bsp, {"kernel": "woop"}, "kernel must be"),
    (vc.Vlf, {"n_directions": 512}, r"n_directions must be .* 513, .*, got 512"),
    (vc.Vlf, {"n_directions": "all"}, "n_directions must be"),
    (vc.Vlf, {"n_directions": 0}, "n_directions must be"),
    (vc.Vlf, {"split": "median"}, "split must be"),
    (vc.Exact, {"order": "by_row"}, "order must be"),
    (vc.Exact, {"coherent": 1}, "coherent must be true or false"),
    (vc.Aqvc, {"c_e": "12"}, "c_e must be a finite number"),
    (vc.Aqvc, {"c_n": True}, "c_n must be a whole number"),
    (vc.PaperForm, {"grid_offset": 1}, "grid_offset must be true or false"),
    (vc.PaperForm, {"grid_seed": -1}, "grid_seed must be"),
    (vc.PaperForm, {"form": "wave"}, 'form must be "waves" or "pairs"'),
    (vc.PaperForm, {"queue": 3}, r"queue must be even and in \[0, 1024\], got 3"),
    (vc.Aqvc, {"paper": "pairs"}, r"paper must be vc.PaperForm\(...\)"),
    (vc.Aqvc, {"c_e_groups": 3}, "c_e_groups must map"),
    (vc.Aqvc, {"c_e_groups": {"vpl": "x"}}, "c_e_groups"),
    (vc.Aqvc, {"refinement": 3}, 'refinement must be "auto", "on" or "off", or map'),
    (vc.Aqvc, {"refinement": "no"}, "refinement must be one of .'auto', 'on', 'off'."),
    (vc.Aqvc, {"refinement": {"lamp": "on"}}, "refinement must name point"),
    (vc.Aqvc, {"refinement": {"vpl": "no"}}, "refinement.'vpl'. must be"),
]


@pytest.mark.parametrize(("cls", "given", "message"), BAD)
def test_a_value_of_the_wrong_kind_is_refused_with_what_must_hold(cls, given, message):
    with pytest.raises(ValueError, match=message):
        cls(**given)


CALLS = [
    ({"scene": 7}, "scene must be a Scene, a file or a built-in name"),
    ({"integrator": vc.Exact()}, "integrator must be vc.Direct"),
    ({"integrator": "whited"}, "unknown integrator 'whited'; did you mean 'whitted'"),
    ({"visibility": vc.Direct()}, "visibility must be vc.Exact"),
    ({"visibility": "aqcv"}, "unknown visibility 'aqcv'; did you mean 'aqvc'"),
    ({"rays": vc.Exact()}, "rays must be vc.Embree"),
    ({"use": "repair"}, "use must be"),
    ({"size": 5}, "size must be"),
    ({"size": (2.5, 4)}, "size must be"),
    ({"size": (0, 4)}, "size must be"),
    ({"spp": 1.5}, "spp must be a whole number"),
    ({"threads": 0}, "threads must be"),
    ({"seed": -1}, "seed must be"),
    ({"camera": 2.5}, "camera must be one of"),
    ({"env": {}}, "env must be"),
]


#: Every call that takes the size of a picture.
SIZED = {
    "render": lambda size: vc.render("cube_on_plane", vc.Direct(), size=size),
    "tiles": lambda size: vc.tiles.render("cube_on_plane", vc.Direct(), size=size),
    "connections": lambda size: vc.connections("cube_on_plane", vc.Direct(), size=size),
    "passes": lambda size: vc.Progressive("cube_on_plane", vc.Direct(), size=size).passes(1),
    "over time": lambda size: vc.passes_over_time(
        "cube_on_plane", vc.Direct(), passes=2, size=size
    ),
    "sweep": lambda size: vc.sweep("cube_on_plane", vc.Direct(), over={"c_e": [4]}, size=size),
    "tune": lambda size: vc.tune("cube_on_plane", vc.Direct(), rel_l1=0.1, size=size),
    "exact": lambda size: vc.testing.ExactFrames(None)("cube_on_plane", "direct", size=size),
    "maps": lambda size: vc.VisibilityMapCache("cube_on_plane").update(size=size),
    "relighting": lambda size: vc.Relighting(vc.VisibilityMapCache("cube_on_plane"), size=size),
}


@pytest.mark.parametrize("call", SIZED)
@pytest.mark.parametrize(
    "size", [3, 1.5, "x", (3,), (4, 4, 4), (0, 4), (4, -1), (1 << 17, 4), (True, 4), {4: 4, 5: 5}]
)
def test_a_size_that_is_none_is_refused_everywhere(call, size):
    with pytest.raises(ValueError, match=r"size must be \(width, height\), both in \[1, 65536\]"):
        SIZED[call](size)


@pytest.mark.parametrize("kind", [np.int8, np.uint64])
def test_whole_numbers_of_numpy_are_numbers(kind):
    """Sums and products of them would overflow."""
    given = {"size": (8, 6), "visibility": vc.Unoccluded(), "use": "correct"}
    want = vc.render("cube_on_plane", vc.Direct(), seed=3, spp=2, first_sample=100, **given)
    got = vc.render(
        "cube_on_plane", vc.Direct(), seed=kind(3), spp=kind(2), first_sample=kind(100), **given
    )
    assert got.sha256 == want.sha256 and got.parameters == want.parameters
    pictures = [
        vc.Progressive("cube_on_plane", vc.Direct(), seed=k(126), spp=k(1), **given)
        for k in (int, kind)
    ]
    assert len({picture.passes(3).sha256 for picture in pictures}) == 1


def test_a_class_in_the_place_of_settings_is_refused():
    scene, given = vc.scenes.cube_on_plane(), {"size": (4, 4), "over": {"c_e": [4]}}
    calls = (
        lambda: scene.oracle(vc.Aqvc),
        lambda: vc.sweep(scene, vc.Direct(), visibility=vc.Aqvc, **given),
        lambda: vc.sweep(scene, vc.Direct, **given),
        lambda: vc.render(scene, vc.Direct(), rays=vc.Bsp, size=(4, 4)),
    )
    for call in calls:
        with pytest.raises(ValueError, match=r"(integrator|visibility|rays) must be "):
            call()


@pytest.mark.parametrize("value", [3.0, {}, "x", None, 1 << 64, -1])
def test_other_arguments_of_the_wrong_kind_are_refused_by_name(value):
    scene, picture = vc.scenes.cube_on_plane(), np.ones((8, 8, 3))
    calls = {
        "at": lambda: vc.VisibilityMapCache(scene).update(size=(4, 4), at=value),
        "seed": lambda: scene.oracle("exact", use="correct", seed=value),
        "power": lambda: vc.testing.assert_unbiased([picture], [picture], power=value),
    }
    if not (isinstance(value, int | float) and value >= 0):
        calls["t_max"] = lambda: vc.FarEnds.directions([[0, 1, 0]], t_max=value)
    if value is not None and value != {}:
        calls["metrics"] = lambda: vc.metrics.compare(picture, picture, metrics=value)
    for name, call in calls.items():
        with pytest.raises(ValueError, match=f"{name} must be"):
            call()


@pytest.mark.parametrize(("given", "message"), CALLS)
def test_render_refuses_an_argument_of_the_wrong_kind(given, message):
    options = {"size": (4, 4), **given}
    scene = options.pop("scene", None) or vc.scenes.cube_on_plane()
    with pytest.raises(ValueError, match=message):
        vc.render(scene, options.pop("integrator", vc.Direct()), **options)


def test_numpy_numbers_become_plain_ones():
    np = pytest.importorskip("numpy")
    settings = vc.Whitted(n_vpls=np.int64(7), vpl_bound=np.float32(0.5))
    assert type(settings.n_vpls) is int and type(settings.vpl_bound) is float
