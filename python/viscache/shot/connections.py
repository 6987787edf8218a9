"""Eye points, lights and samples of the renderer, and frames made from answers about them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base.progress import progress_bar
from viscache.base.provenance import provenance
from viscache.frame import Frame
from viscache.oracles.oracle import BlockAnswer, Oracle, PairAnswer
from viscache.oracles.points import EyePoints, FarEnds, ends_of, pack
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.scenes import sources
from viscache.settings.aqvc import LIGHT_GROUPS
from viscache.settings.checks import checked_floats, require
from viscache.settings.integrators import (
    AmbientOcclusion,
    Direct,
    Integrator,
    Whitted,
    described,
    eye_settings,
)
from viscache.settings.rays import Rays
from viscache.settings.spelling import spelled
from viscache.shot.shot import BareShot, ShotArguments, frame_settings, of_shot

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: Samples of the sky by lobes, where "environment" names directions that all eye points share.
LOBES = "lobes"

Answer: TypeAlias = "BlockAnswer | PairAnswer | npt.NDArray[Any] | tuple[Any, Any]"


class Samples:
    """Samples that belong to one eye point each: of area lights, a sky or a hemisphere.

    Attributes
    ----------
    index : (K,) uint32
        Sample k belongs to eye point `index[k]`.
    ends : FarEnds of K ends
    contributions : (K, 3) float32
        Contribution of each to its pixel if it is visible, linear RGB.
    """

    def __init__(self, arrays: dict[str, Any]) -> None:
        self.index: npt.NDArray[np.uint32] = arrays["index"]
        self.contributions: npt.NDArray[np.float32] = arrays["contributions"]
        self.ends: FarEnds = ends_of(arrays)

    def __len__(self) -> int:
        return len(self.index)


class Connections:
    """All visibility queries of a frame, and the frame from their answers; see `vc.connections`.

    Attributes
    ----------
    eyes : EyePoints
        Eye points of all tiles in the renderer's order: sample × branch at mirrors and glass ×
        side.
    groups : dict of str to FarEnds
        Lights shared by all eye points, by light group: "point", "directional", "vpl", and
        "environment" with shared directions.
    samples : dict of str to Samples
        Samples that belong to one eye point each: "area", "environment", "ambient", and "lobes":
        samples of the sky by lobes, beside its shared directions. Their light is in the layer
        "environment", and so are their counters.
    """

    def __init__(
        self,
        scene: Scene,
        integrator: Any,
        rays: Rays | str | None,
        frame: _core.FrameSettings,
        camera: _core.Camera,
    ) -> None:
        self._scene, self._integrator, self._rays = scene, integrator, rays
        self._frame, self._camera = frame, camera
        self._core = eye_settings(integrator)
        self._caster = scene.caster(rays, threads=frame.threads)
        self._taps = _core.FrameTaps(scene._core, self._caster, camera, self._core, frame)
        tiles = self._taps.tiles()
        joined = {
            name: np.concatenate([tile[name] for tile in tiles])
            for name in ("positions", "normals", "density", "origins")
        }
        self.eyes = EyePoints(
            joined["positions"],
            joined["normals"],
            joined["density"],
            _origins=joined["origins"],
            _tiles=tuple(tiles),
        )
        lights = self._taps.lights()
        self._light_number = {LIGHT_GROUPS[arrays["group"]]: i for i, arrays in enumerate(lights)}
        self.groups = {LIGHT_GROUPS[arrays["group"]]: ends_of(arrays) for arrays in lights}
        self.samples = {
            self._samples_name(group): Samples(self._taps.samples(group))
            for group in self._taps.sample_groups()
        }

    def wanted(self, group: str) -> npt.NDArray[np.uint64]:
        """Rows of bits (N, ⌈M/64⌉): connections that have a contribution, or the picked ones."""
        return self._taps.wanted(self._number(group))

    def contributions(self, group: str, rows: slice | None = None) -> npt.NDArray[np.float32]:
        """Contributions of connections to the pixels of some eye points, before visibility.

        Parameters
        ----------
        group : str
            One of `groups`.
        rows : slice, optional
            Eye points, a slice without a step. All by default, which takes 12·N·M bytes.

        Returns
        -------
        (rows, M, 3) float32
            Linear RGB. The sum over visible connections is the light of the eye point. With
            `pick`, contributions have the weight of the pick, and all others are 0.
        """
        self._number(group)
        begin, end, step = (rows or slice(None)).indices(len(self.eyes))
        require(step == 1, "rows must be a slice without a step", rows)
        return self._taps.contributions(LIGHT_GROUPS.index(group), begin, max(begin, end))

    def answers(self, visibility: Any, *, use: Any = None) -> dict[str, Answer]:
        """Answers of a visibility setting to every query of the frame, as in `viscache.render`.

        Returns
        -------
        dict
            Group → answer, for `frame`.
        """
        result = self._taps.ask(self.oracle(visibility, use=use)._source())
        counters, timings = result["counters"], result["timings"]

        def counted(group: str) -> dict[str, Any]:
            own = counters["groups"].get(group, {"queries": 0, "rays": 0})
            return {**own, "frame": counters}

        found: dict[str, Answer] = {}
        for group, ends in self.groups.items():
            block = result["lights"][self._light_number[group]]
            found[group] = BlockAnswer(
                block["bits"], len(ends), block.get("weights"), counted(group), timings
            )
        for number, samples in result["samples"].items():
            group = self._samples_name(number)
            found[group] = PairAnswer(
                samples["visible"],
                samples.get("weights"),
                counted(group),
                timings,
                (samples["order"], samples["run_end"]),
            )
        return found

    def oracle(self, visibility: Any, *, use: Any = None) -> Oracle:
        """`scene.oracle` with the frame's rays, seed, samples per pixel and threads."""
        return Oracle(
            self._scene,
            visibility,
            rays=self._rays,
            use=use,
            seed=self._frame.seed,
            spp=self._frame.spp,
            threads=self._frame.threads,
        )

    def frame(self, answers: Mapping[str, Answer], *, progress: Any = False) -> Frame:
        """The frame that results from answers. Groups without an answer stay dark.

        Parameters
        ----------
        answers : mapping of group to answer
            What `oracle.block` and `oracle.pairs` return. For shared groups also (N, M) bool or
            bits, for samples also (K,) bool. All of these also as (visible, weights).
        progress : bool or callable
            True shows a bar; a callable gets (done, total).

        Returns
        -------
        Frame
            With the answers of a built-in setting it has the same bytes as `viscache.render`.

        Raises
        ------
        ValueError
            Groups that the frame does not have, shapes that do not fit.
        """
        known = [*self.groups, *self.samples]
        given = _core.GivenAnswers(self._taps)
        for group, answer in answers.items():
            require(group in known, f"answers must be of {', '.join(known)}", group)
            if group in self.groups:
                self._give_block(given, group, answer)
            else:
                self._give_samples(given, group, answer)
        with progress_bar(progress) as report:
            result = _core.render_frame(
                self._scene._core,
                self._caster,
                self._camera,
                self._core,
                self._frame,
                given.source(),
                progress=report,
            )
        counted = [a.counters for a in answers.values() if isinstance(a, BlockAnswer | PairAnswer)]
        rays = sum(int(c.get("rays", 0)) for c in counted)
        counters = result["counters"]
        counters["rays"] = rays
        counters["ray_reduction"] = counters["queries"] / rays if rays else 0.0
        made = Frame(
            layers=result["layers"],
            counters=counters,
            timings=result["timings"],
            parameters={
                "scene": self._scene.spec or self._scene.name,
                "scene_hash": self._scene.content_hash,
                "integrator": described(self._integrator),
                "visibility": {"name": "given"},
                "size": [self._frame.width, self._frame.height],
                "spp": self._frame.spp,
                "seed": self._frame.seed,
                "camera": self._camera.name,
            },
            provenance=provenance(),
            warnings=list(self._scene.warnings),
        )
        made.counters["sha256"] = made.sha256
        return made

    def __repr__(self) -> str:
        shared = [f"{name}: {len(ends)}" for name, ends in self.groups.items()]
        own = [f"{name}: {len(samples)} samples" for name, samples in self.samples.items()]
        return f"Connections({len(self.eyes)} eye points; {', '.join([*shared, *own])})"

    def _samples_name(self, number: int) -> str:
        return LOBES if LIGHT_GROUPS[number] in self.groups else LIGHT_GROUPS[number]

    def _number(self, group: str) -> int:
        require(group in self.groups, f"group must be one of {', '.join(self.groups)}", group)
        return self._light_number[group]

    def _give_block(self, given: _core.GivenAnswers, group: str, answer: Answer) -> None:
        if isinstance(answer, BlockAnswer):
            bits, weights = answer.bits, answer.weights
        else:
            seen, weights = answer if isinstance(answer, tuple) else (answer, None)
            seen = np.asarray(seen)
            bits = pack(seen) if seen.dtype == bool and seen.ndim == 2 else seen
        require(bits.dtype == np.uint64, f"answers[{group!r}] must be bool or bits", bits.dtype)
        given.block(
            LIGHT_GROUPS.index(group),
            np.ascontiguousarray(bits),
            _finite(weights, group),
            len(self.groups[group]),
        )

    def _give_samples(self, given: _core.GivenAnswers, group: str, answer: Answer) -> None:
        order: tuple[Any, Any] = ([], [])
        seen: Any
        weights: Any
        if isinstance(answer, PairAnswer):
            seen, weights, order = answer.visible, answer.weights, answer._order or order
        else:
            seen, weights = answer if isinstance(answer, tuple) else (answer, None)
        seen = np.asarray(seen)
        require(seen.dtype == bool, f"answers[{group!r}] must be bool", seen.dtype)
        given.samples(_group_number(group), seen, _finite(weights, group), *order)


def _group_number(name: str) -> int:
    """The light group of a name in `Connections.groups` or `Connections.samples`."""
    return LIGHT_GROUPS.index("environment" if name == LOBES else name)


def _finite(weights: Any, group: str) -> npt.NDArray[np.float32] | None:
    if weights is None:
        return None
    rows: npt.NDArray[np.float32] = checked_floats(weights, f"weights of {group!r}")
    good = bool(np.isfinite(rows).all())
    require(good, f"weights of answers[{group!r}] must be finite", "values that are not")
    return rows


def trace_eye_points(
    scene: Scene,
    integrator: Integrator,
    *,
    size: tuple[int, int],
    spp: int = 1,
    camera: str | int | _core.Camera | None = None,
) -> dict[str, npt.NDArray[Any]]:
    """The eye points of a whole frame with exact rays, in one array each.

    They are "position", "normal", "origin" and "throughput" (N, 3), "density" and "pixel" (N,).
    """
    frame = frame_settings(size, spp, 0, None)
    view, core = find_camera(scene, camera), eye_settings(integrator)
    return _core.trace_eye_points(scene._core, scene.caster(), view, core, frame)


@spelled
@of_shot("visibility", "use")
def connections(
    scene: Scene | str | os.PathLike[str],
    integrator: Direct | Whitted | AmbientOcclusion | str | None = None,
    **shot: Unpack[ShotArguments],
) -> Connections:
    """The visibility queries of a frame as arrays: eye points, lights, samples, contributions.

    Parameters
    ----------
    scene, rays, size, spp, seed, threads, camera, env
        As in `viscache.Shot`.
    integrator : Direct, Whitted or AmbientOcclusion
        Samples must be drawn before visibility is known. So `Bdpt`, environment="product" and
        shared directions of ambient occlusion are refused.

    Returns
    -------
    Connections
        It holds the frame's eye points and samples: 60 bytes per eye point, 76 per sample, and a
        bit per connection with shared lights.

    Examples
    --------
    >>> import viscache as vc
    >>> scene, light = vc.scenes.cube_on_plane(), vc.Whitted(n_vpls=16)
    >>> conn = vc.connections(scene, light, size=(32, 20))
    >>> frame = conn.frame(conn.answers(vc.Aqvc(c_e=8)))
    >>> cached = vc.render(scene, light, visibility=vc.Aqvc(c_e=8), size=(32, 20))
    >>> frame.sha256 == cached.sha256
    True
    """
    given = BareShot(scene, integrator, **shot)
    integrator = given.setting("integrator")
    fits = isinstance(integrator, Direct | Whitted | AmbientOcclusion)
    require(
        fits,
        "integrator must be vc.Direct(...), vc.Whitted(...) or vc.AmbientOcclusion(...)",
        integrator,
    )
    product = getattr(integrator, "environment", "") == "product"
    require(not product, 'environment must not be "product" for connections', "product")
    shared = getattr(integrator, "directions", "") == "shared"
    require(not shared, 'directions must be "own" for connections', "shared")
    lit = sources.opened(given.opened)
    if isinstance(integrator, AmbientOcclusion):
        integrator = integrator.within(lit.bounds)
    if given.env is not None:
        lit = lit.with_environment(given.env, threads=given.threads)
    view = find_camera(lit, given.camera)
    frame = frame_settings(frame_size(given.size, view), given.spp, given.seed, given.threads)
    return Connections(lit, integrator, given.rays, frame, view)
