"""The same bytes for any number of threads, and other bytes where they should be others."""

import hashlib

import numpy as np
import pytest

import viscache as vc
from render.mitsuba_scene import Look, Model, ball, box, quad

ROOM = Model(
    (
        box((-2, 0, -2), (2, 2.5, 2), look=Look(base_color=(0.7, 0.6, 0.5))).reversed(),
        box((-1, 0, -1), (-0.2, 1, -0.4), look=Look(kind="mirror", specular=(0.9, 0.9, 0.9))),
        ball((0.7, 0.5, 0.3), 0.5, look=Look(kind="dielectric")),
        box((0.2, 0, -1.4), (0.9, 0.7, -0.8), look=Look(kind="glossy", base_color=(0.3, 0.2, 0.1))),
        quad((-0.4, 2.4, -0.4), (0.8, 0, 0), (0, 0, 0.8), emission=(8, 8, 8)),
    ),
    points=(((1.5, 2, 1.5), (1, 1, 1)),),
    directions=(((0, 0.6, 0.8), (0.1, 0.1, 0.1)),),
    spheres=(((-1.5, 2, 0), 0.1, (9, 9, 9)),),
    env=(0.2, 0.2, 0.2),
    origin=(0, 1.2, 1.8),
)

INTEGRATORS = [
    vc.Direct(n_area=4, n_environment=2, n_brdf=2),
    vc.Whitted(n_vpls=24, n_area=4, n_environment=2, n_brdf=2),
    vc.AmbientOcclusion(n_samples=8, max_distance=0.5),
    vc.Bdpt(max_depth=4),
]


@pytest.fixture(scope="module")
def room():
    return ROOM.to_viscache()


def signature(frame):
    layers = {n: hashlib.sha256(p.tobytes()).hexdigest() for n, p in frame.layers.items()}
    engine = frame.parameters.get("engine", {})
    return {
        "layers": layers,
        "counters": frame.counters,
        "engine": engine if "direction_rays" in engine else None,
    }


SKY = vc.Direct(environment="shared", n_environment=128, n_area=0)
AMBIENT = vc.AmbientOcclusion(n_samples=129, directions="shared", engine="batch", max_distance=0.5)
EVERY = vc.Aqvc(c_e=16, exact_groups=())
KEYED = vc.Bdpt(max_depth=4, camera_connections="keyed")
SHOTS = {
    **{type(i).__name__: (i, {}) for i in INTEGRATORS},
    "picks": (vc.Whitted(pick=2, n_vpls=24, n_area=0), {}),
    "cache by the BSP": (INTEGRATORS[1], {"visibility": vc.Aqvc(c_e=8), "rays": vc.Bsp()}),
    "shadow maps": (INTEGRATORS[1], {"visibility": vc.ShadowMap(resolution=200)}),
    "table of paths": (KEYED, {"visibility": vc.Aqvc(table_bytes=16 << 20)}),
    "keys of paths": (KEYED, {"visibility": vc.Aqvc(paper=vc.PaperForm(storage="exact"))}),
    **{f"sky by {e}": (SKY, {"visibility": vc.Exact(sky_engine=e)}) for e in ("batch", "auto")},
    "shared ambient": (AMBIENT, {}),
    "audited pixels": (INTEGRATORS[1], {"visibility": vc.Aqvc(c_e=16), "audit": "pixels"}),
    "audited queries": (INTEGRATORS[1], {"visibility": EVERY, "audit": vc.AuditQueries(share=0.1)}),
}


@pytest.mark.parametrize("name", SHOTS)
def test_any_number_of_threads_gives_the_same_bytes(name, room):
    """16 samples per pixel make tiles of 32 pixels: 8 tiles share the work."""
    integrator, options = SHOTS[name]
    options = {"size": (97, 34), "spp": 16, **options}
    frames = [vc.render(room, integrator, seed=3, threads=n, **options) for n in (1, 8, 3)]
    assert name == "shared ambient" or frames[0].parameters["tile_edge_px"] <= 64
    assert frames[1].provenance["threads"] > 1
    for frame in frames[1:]:
        assert signature(frame) == signature(frames[0])
        assert frame.warnings == frames[0].warnings
    other = vc.render(room, integrator, seed=4, **options)
    assert signature(other) != signature(frames[0])


def test_a_scene_built_again_gives_the_same_bytes(room):
    again = ROOM.to_viscache()
    assert again.content_hash == room.content_hash
    a, b = (vc.render(s, INTEGRATORS[1], size=(24, 16)) for s in (room, again))
    assert signature(a) == signature(b)


@pytest.mark.parametrize(
    ("integrator", "groups"),
    [
        (INTEGRATORS[1], {"point", "directional", "area", "environment", "vpl"}),
        (INTEGRATORS[3], {"point", "directional", "area", "environment", "connection", "camera"}),
    ],
    ids=["whitted", "bdpt"],
)
def test_the_parts_add_up_to_the_image(integrator, groups, room):
    frame = vc.render(room, integrator, size=(40, 30), spp=4)
    total = sum(frame.layers[g].astype(np.float64) for g in ("emitted", *groups))
    np.testing.assert_allclose(frame.image, total, rtol=1e-4, atol=1e-6)
    counters = frame.counters
    assert set(counters["groups"]) == groups and counters["sha256"] == frame.sha256
    for name in ("queries", "rays", "occluded"):
        assert sum(g[name] for g in counters["groups"].values()) == counters[name]
    for group in counters["groups"].values():
        assert 0 < group["occluded"] <= group["queries"] == group["rays"]


def test_pixels_of_one_seed_share_no_samples():
    """Neighbours under one constant light differ, as do frames of other seeds."""
    plane = quad((-50, 0, -50), (0, 0, 100), (100, 0, 0))
    above = {"origin": (0, 5, 0), "target": (0, 0, 0), "up": (0, 0, 1)}
    scene = Model((plane,), env=(1, 1, 1), **above).to_viscache()
    frames = [
        vc.render(scene, vc.Direct(n_brdf=0), size=(32, 32), seed=s).image[..., 0] for s in (0, 1)
    ]
    noise = [f.astype(float) - f.mean() for f in frames]
    assert noise[0].std() > 0.01
    for a, b in (
        (noise[0], noise[1]),
        (noise[0][:, 1:], noise[0][:, :-1]),
        (noise[0][1:], noise[0][:-1]),
    ):
        assert abs((a * b).mean() / noise[0].var()) < 5 / 32, "correlated"
