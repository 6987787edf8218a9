"""Every combination that is promised to be unbiased has the expectation of exact frames.

A cell is an integrator, a kind of light, an oracle, a use of it and a number of picks. All that the
registries and the table of combinations let through and promise are here. Frames are compared with
exact ones of the same seeds, by energy and blocks. A cell renders as many seeds as it takes to see
one percent of the energy, and prints what it would have seen.
"""

import functools
import itertools
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

import viscache as vc
from viscache import _core
from viscache.scene.environments import apply_environment
from viscache.settings import by_name, combinations
from viscache.settings.integrators import eye_settings
from viscache.shot.frame_plan import check_settings
from viscache.shot.shot import frame_settings

#: Four blocks.
SIZE = (64, 64)
#: The bias of the energy that each cell must be able to see, as often as `POWER`.
ENERGY, POWER = 0.01, 0.99
#: Share of sound runs of all cells together in which one fails, and looks at each cell at most.
FAMILY, LOOKS = 0.01, 6
#: Seeds of the first look, and how much more the next one has at most.
FIRST, MORE = 12, 4.0


@functools.cache
def scene(lights):
    """A few plates above a floor, one of them shiny, and one kind of light."""
    d, rng = vc.SceneDescription(), np.random.default_rng(8)
    grey = d.add_material(base_color=(0.7, 0.6, 0.5))
    shiny = d.add_material(
        vc._core.MaterialKind.GLOSSY, base_color=(0.3,) * 3, specular=(0.4,) * 3, roughness=0.3
    )
    floor = np.float32([[-3, 0, -3], [3, 0, -3], [3, 0, 3], [-3, 0, 3]])
    d.add_mesh(floor, np.uint32([[0, 2, 1], [0, 3, 2]]), material=grey)
    wall = np.float32([[-3, 0, -3], [3, 0, -3], [3, 3, -3], [-3, 3, -3]])
    d.add_mesh(wall, np.uint32([[0, 1, 2], [0, 2, 3]]), material=shiny)
    for _ in range(10):
        corners = rng.uniform([-1.5, 0.2, -1.5], [1.5, 1, 1.5]) + rng.normal(0, 0.35, (3, 3))
        d.add_mesh(np.float32(corners), np.uint32([[0, 1, 2]]), material=grey)
    if lights == "points":
        places = rng.uniform([-2, 2, -2], [2, 3.5, 2], (14, 3))
        d.add_point_lights(places, rng.uniform(0.5, 2, (14, 3)).astype(np.float32))
    if lights == "areas":
        for _ in range(4):
            corners = rng.uniform([-2, 2.5, -2], [2, 3.5, 2]) + 0.8 * np.eye(3)[[1, 0, 2]]
            lamp = {"emission": tuple(rng.uniform(2, 6, 3)), "emits_two_sided": True}
            d.add_mesh(np.float32(corners), np.uint32([[0, 1, 2]]), material=grey, **lamp)
    if lights == "sky":
        sky = np.abs(rng.normal(size=(8, 16, 3))) + 0.2
        apply_environment(d, sky.astype(np.float32))
    d.add_camera((0.5, 2.6, 4), (0, 0.4, 0))
    return vc.Scene.from_description(d)


#: How each integrator takes each kind of light: the scene's lights, and its own settings.
NONE = {"n_area": 0, "n_environment": 0, "n_brdf": 0}
DIRECT = {
    "points": ("points", NONE),
    "areas": ("areas", {**NONE, "n_area": 8, "n_brdf": 1}),
    "sky": ("sky", {**NONE, "n_environment": 4, "n_brdf": 2}),
    "shared sky": ("sky", {**NONE, "environment": "shared", "n_environment": 96}),
    "product sky": ("sky", {"environment": "product", "n_environment": 4}),
}
PATHS = {name: (name, {"max_depth": 3}) for name in ("points", "areas", "sky")}
ASKED = {
    "direct": DIRECT,
    "whitted": {
        name: (lights, {**settings, "n_vpls": 96 if name == "virtual lights" else 0})
        for name, (lights, settings) in {"virtual lights": DIRECT["points"], **DIRECT}.items()
    },
    "bdpt": PATHS,
    "ao": {"hemisphere": ("none", {"n_samples": 8, "max_distance": 2.0})},
}


@dataclass(frozen=True)
class Own:
    """An oracle of one's own, whose answers are wrong."""

    answers: str

    def block(self, eyes, lamps, wanted):
        if self.answers == "always":
            return np.ones(wanted.shape, bool)
        if self.answers == "inverted":
            return ~np.asarray(eyes.trace(lamps, wanted))
        return _noise(eyes.positions)[:, None] ^ _noise(lamps.positions)[None]

    def pairs(self, eyes, index, ends):
        if self.answers == "always":
            return np.ones(len(index), bool)
        noise = _noise(eyes.positions[index]) ^ _noise(ends.positions)
        if self.answers == "random":
            return noise
        # Without a ray: seen from one half of the floor, which is as wrong
        return eyes.positions[index, 0] > 0


def _noise(places):
    sums = places.astype(float) @ [12.9898, 78.233, 37.719]
    return np.asarray(np.abs(np.sin(sums)) * 43758.5453 % 1 < 0.5)


ORACLES = {
    "exact": vc.Exact(),
    "aqvc": vc.Aqvc(c_e=16, exact_groups=()),
    "vismap": vc.VisMaps(m=4, n_startup=1, d_max=1000.0),
    "shadow_map": vc.ShadowMap(resolution=24),
    "nee_plus_plus": vc.NeePlusPlus(
        n_voxels=4, n_directions=4, learn_pixels=512, min_probability=0.2
    ),
    "unoccluded": vc.Unoccluded(),
    **{f"own {answers}": Own(answers) for answers in ("inverted", "random", "always")},
}
USES = {"as it is": None, "share": vc.Correct(share=0.5), "contribution": "correct"}
PICKS = (0, 4)


@dataclass(frozen=True)
class Cell:
    integrator: str
    lights: str
    oracle: str
    use: str
    pick: int

    def __str__(self):
        picks = f", {self.pick} picks" if self.pick else ""
        return f"{self.integrator}, {self.lights}, {self.oracle}, {self.use}{picks}"

    @property
    def settings(self):
        """The integrator's; a TypeError if it picks no lights."""
        _, given = ASKED[self.integrator][self.lights]
        made = by_name.NAMES["integrator"][self.integrator](**given)
        return replace(made, pick=self.pick) if self.pick else made

    @property
    def scene(self):
        return scene(ASKED[self.integrator][self.lights][0])

    def is_promised(self):
        """Whether it exists, is promised to be unbiased, and is not the exact frame itself."""
        shared = self.lights in ("points", "virtual lights", "shared sky")
        if self.oracle == "vismap" and "sky" not in self.lights:
            return False  # maps are of a sky
        known = {f.name for f in fields(by_name.NAMES["integrator"][self.integrator])}
        if self.pick and not (shared and "pick" in known):
            return False
        oracle, use = ORACLES[self.oracle], USES[self.use]
        try:
            settings = self.settings
            check_settings(scene("none"), settings, vc.Embree(), oracle, use, None)
            request = combinations.Request(
                integrator=settings, rays=vc.Embree(), visibility=oracle, use=use
            )
            combinations.check(request)
        except ValueError:
            return False
        exact = self.oracle == "exact" and (self.pick == 0 or self.use != "as it is")
        return request.is_unbiased and not exact

    def frame(self, seed):
        asked = {"visibility": ORACLES[self.oracle], "use": USES[self.use]}
        return vc.render(self.scene, self.settings, size=SIZE, seed=seed, threads=1, **asked)


CELLS = [
    cell
    for integrator, asked in ASKED.items()
    for cell in itertools.starmap(
        Cell, itertools.product([integrator], asked, ORACLES, USES, PICKS)
    )
    if cell.is_promised()
]
ALPHA = FAMILY / LOOKS / len(CELLS)


def covering(cells):
    """A few cells that hold every pair of values of two dimensions that any cell has."""

    def pairs(cell):
        values = [(f.name, getattr(cell, f.name)) for f in fields(cell)]
        return set(itertools.combinations(values, 2))

    left, chosen = set().union(*map(pairs, cells)), []
    while left:
        best = max(cells, key=lambda cell: len(pairs(cell) & left))
        chosen.append(best)
        left -= pairs(best)
    return chosen


@functools.lru_cache(maxsize=4096)
def exact_image(integrator, lights, seed):
    """All lights, exact visibility: for all oracles, uses and picks of these."""
    return np.asarray(Cell(integrator, lights, "exact", "as it is", 0).frame(seed).image)


def found(cell, image, energy=ENERGY):
    """The test of as many seeds as it takes to see `energy`; AssertionError if it is biased."""
    n = FIRST
    for look in range(LOOKS):
        frames = [image(seed) for seed in range(n)]
        exact = [exact_image(cell.integrator, cell.lights, seed) for seed in range(n)]
        given = {"alpha": ALPHA, "power": POWER, "paired": True}
        first = vc.testing.assert_unbiased(frames, exact, energy=0.999, **given)
        if first.detectable <= energy or look == LOOKS - 1:
            break
        n = int(np.ceil(n * min(MORE, 1.15 * (first.detectable / energy) ** 2)))
    return vc.testing.assert_unbiased(frames, exact, energy=energy, **given)


def check(cell):
    """No bias, and a loss of twice what must be seen is found."""
    images = {}

    def image(seed):
        if seed not in images:
            images[seed] = cell.frame(seed).image
        return images[seed]

    print(f"{cell}: {found(cell, image)}")
    darker = [(1 - 2 * ENERGY) * one for one in images.values()]
    exact = [exact_image(cell.integrator, cell.lights, seed) for seed in images]
    with pytest.raises(AssertionError, match="the frames are biased"):
        vc.testing.assert_unbiased(darker, exact, alpha=ALPHA, power=POWER, paired=True)


def test_every_integrator_and_cache_of_the_registry_has_cells():
    assert set(ASKED) == set(by_name.NAMES["integrator"])
    assert set(ORACLES) >= set(by_name.NAMES["visibility"])
    for dimension, known in (("integrator", ASKED), ("oracle", ORACLES), ("use", USES)):
        assert {getattr(cell, dimension) for cell in CELLS} == set(known)
    assert {cell.pick for cell in CELLS} == set(PICKS)


@pytest.mark.stat
def test_both_techniques_of_a_sky_have_the_mean_of_one():
    def frames(first, **given):
        light = vc.Direct(n_area=0, **given)
        return [
            vc.render(scene("sky"), light, size=SIZE, seed=first + i, threads=1) for i in range(48)
        ]

    both, one = frames(0, n_environment=4, n_brdf=2), frames(100, n_environment=12, n_brdf=0)
    print(vc.testing.assert_unbiased(both, one, energy=0.015))


def test_corrected_own_samples_are_divided_by_their_share():
    check(Cell("direct", "areas", "unoccluded", "share", 0))


def rendered(cell, source):
    """Frames whose answers come from a source of the core."""

    def image(seed):
        lit = cell.scene
        caster = lit.caster(vc.Embree())
        parts = (lit._core, caster, lit.cameras[0], eye_settings(cell.settings))
        made = _core.render_frame(
            *parts, frame_settings(SIZE, 1, seed, 1), source(lit, caster, seed)
        )
        return np.asarray(made["layers"]["color"])

    return image


def corrected(share, *, weighted):
    return lambda lit, caster, seed: _core.ResidualSource(
        lit._core, caster, _core.UnoccludedSource(), share=share, seed=seed, weighted=weighted
    )


def roulette(*, weighted):
    voxels = ORACLES["nee_plus_plus"].core()
    return lambda lit, caster, seed: _core.RouletteSource(
        lit._core, caster, voxels, seed=seed, weighted=weighted
    )


def uniformly_picked(seed):
    """Picks by contribution, with the weight of an even choice."""
    cells = (Cell("direct", "points", "exact", "as it is", n) for n in PICKS)
    every, few = (vc.connections(cell.scene, cell.settings, size=SIZE, seed=seed) for cell in cells)
    answers = few.answers(vc.Exact())
    for group in few.groups:
        full, weighted = (taps.contributions(group).sum(axis=2) for taps in (every, few))
        weight = np.divide(weighted, full, where=weighted > 0, out=np.ones_like(full))
        count = (full > 0).sum(axis=1, keepdims=True)
        even = np.where(count > PICKS[1], count / PICKS[1] / weight, 1)
        answers[group] = (answers[group].visible, even)
    return np.asarray(few.frame(answers).image)


def alone(oracle):
    """Frames of an oracle in place of visibility."""
    return lambda seed: np.asarray(replace(POINTS, oracle=oracle).frame(seed).image)


POINTS, AREAS, SKY, SHARED = (
    Cell("direct", lights, "exact", "as it is", 0)
    for lights in ("points", "areas", "product sky", "shared sky")
)


def replaced_maps(seed):
    maps = {"visibility": ORACLES["vismap"], "use": "replace"}
    return np.asarray(vc.render(SKY.scene, SKY.settings, size=SIZE, seed=seed, **maps).image)


#: What goes wrong in each kind: the cell, and frames that are biased.
CONTROLS = {
    "corrections of weight 1": (SHARED, rendered(SHARED, corrected(None, weighted=False))),
    "of even shares": (POINTS, rendered(POINTS, corrected(0.5, weighted=False))),
    "of own samples": (AREAS, rendered(AREAS, corrected(0.5, weighted=False))),
    "roulette of weight 1": (POINTS, rendered(POINTS, roulette(weighted=False))),
    "maps in place of visibility": (SKY, replaced_maps),
    "picks of even weights": (POINTS, uniformly_picked),
    **{
        f"{name} alone": (POINTS, alone(name))
        for name, oracle in ORACLES.items()
        if not combinations.Request(integrator=None, rays=None, visibility=oracle).is_unbiased
    },
}


@pytest.mark.stat
@pytest.mark.parametrize(
    "control",
    [
        pytest.param(name, marks=pytest.mark.release) if name.startswith("maps") else name
        for name in CONTROLS
    ],
)
def test_what_is_wrong_in_its_kind_is_found_biased(control):
    cell, image = CONTROLS[control]
    with pytest.raises(AssertionError, match="the frames are biased"):
        found(cell, image)


@pytest.mark.slow
@pytest.mark.stat
@pytest.mark.parametrize("cell", covering(CELLS), ids=str)
def test_cells_that_hold_every_pair_of_settings_are_unbiased(cell):
    check(cell)


@pytest.mark.release
@pytest.mark.stat
@pytest.mark.parametrize("cell", CELLS, ids=str)
def test_every_cell_is_unbiased(cell):
    check(cell)
