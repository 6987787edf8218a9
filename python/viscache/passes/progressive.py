"""Pictures that converge: passes of new eye samples, whose caches go on from pass to pass."""

from __future__ import annotations

import copy
import dataclasses
import math
import os
import time
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.aqvc.rows import AqvcRows
from viscache.base.progress import Progress, step_bar
from viscache.base.sharing import Turn, Uncopied
from viscache.frame import Frame
from viscache.frame.emitted_light import light_on_surfaces
from viscache.frame.html import frame_html
from viscache.oracles.correct import CERTAIN, Correct
from viscache.oracles.learned import PassMemory, shares_after
from viscache.passes import progressive_state
from viscache.passes.live_view import LiveView
from viscache.scene import Scene, Sky
from viscache.scene.environments import environment_pixels
from viscache.scenes import sources
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import Bdpt, Direct, Integrator, Whitted
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Aqvc, Exact, NeePlusPlus, VisMaps
from viscache.shot.render import render_part, seed_of
from viscache.shot.shot import BareShot, ShotArguments, of_shot, require_same
from viscache.shot.voxel_counts import VoxelCounts
from viscache.vismap.pass_maps import PassMaps

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: E|x| of a normal variable of standard deviation 1.
MEAN_DEVIATION = math.sqrt(2 / math.pi)
LEAST_PASSES = 4  # an estimate of noise needs some


@spelled
class Progressive(Uncopied):
    """A picture that gets better pass by pass.

    Every pass has new eye samples. The virtual lights and shared directions stay the same, or are
    renewed every `renew` passes. Caches go on from pass to pass (see `visibility`). With
    `use="correct"`, the default for a cache, rays for a small share of the queries correct its
    errors, so the picture converges to that of exact visibility.

    The bytes of n passes do not depend on the number of threads, on interrupts, nor on how many
    calls or saved states they took.

    Parameters
    ----------
    scene : Scene, path or str
    integrator : Direct, Whitted, AmbientOcclusion, Bdpt or str
        `Bdpt` has new light paths in every pass, and keeps nothing.
    visibility : Exact, Aqvc, ... or str
        As for `vc.render`, also an oracle of your own. What is kept from pass to pass:

        - the rows of `Aqvc` in the form "waves" (`rows`): later passes trace only cells and lights
          that none before had. With corrections and the default preset, parameters that are not
          given are C_E = 16, C_N = 2, C_Z = 1 and C_R = 2: fewer and larger cells;
        - what `NeePlusPlus` has learnt (`counts`): every pass adds a small frame of its own;
        - the records of `VisMaps` (`maps`): before each pass, pixels get the records that they need
          at another position. A given cache stays as it is, unless `update=True`: then passes
          refine a copy. With `count_misses=True`, records that rays contradict are removed.
    use : {"replace", "correct"} or Correct, optional
        "correct" unless visibility is exact. "replace": faster passes whose mean keeps the cache's
        error; that of `NeePlusPlus` is Russian roulette, which has none.
    size, spp, seed, threads, camera, env, rays
        As for `vc.render`; `spp` is that of one pass. Pictures of different seeds have nothing in
        common. A sky is read, or copied, here.
    renew : int >= 1, optional
        Passes with the same lights. Always the same by default: then the picture converges to that
        of these lights.
    first_pass : int >= 0
        Number of the first pass. A pass is keyed by (seed, number), lights by the seed alone. So
        pictures of one seed converge to the same picture. Blocks of 512 samples per pixel are
        independent of each other; within a block, samples of eyes, lights and skies, and picks, are
        well spread over all passes.
    max_bytes : int in [2^20, 2^44]
        Room for the rows (`AqvcRows`).

    Attributes
    ----------
    rows : AqvcRows or None
    counts : VoxelCounts or None
    maps : PassMaps or None
        `maps.cache` is the `VisibilityMapCache` of the passes so far.

    Examples
    --------
    >>> import viscache as vc
    >>> picture = vc.Progressive(
    ...     "room?triangles=3000", vc.Whitted(n_vpls=64), visibility="aqvc", size=(64, 40)
    ... )
    >>> frame = picture.passes(8)
    >>> picture.n_passes, frame.layers["variance"].shape
    (8, (40, 64, 3))
    """

    _instead = "use save and load, or merge"

    @of_shot(visibility="aqvc")
    def __init__(
        self,
        scene: Scene | str | os.PathLike[str],
        integrator: Integrator | str | None = None,
        *,
        renew: int | None = None,
        first_pass: int = 0,
        max_bytes: int = 1 << 30,
        **shot: Unpack[ShotArguments],
    ) -> None:
        require(
            is_whole(first_pass) and 0 <= first_pass < 1 << 30,
            "first_pass must be a whole number in [0, 2^30)",
            first_pass,
        )
        require(
            renew is None or (is_whole(renew) and renew >= 1),
            "renew must be a whole number >= 1",
            renew,
        )
        given = BareShot(scene, integrator, **shot)
        for name, value in (("seed", given.seed), ("spp", given.spp)):
            require(is_whole(value), f"{name} must be a whole number", value)
        self.scene = sources.opened(given.opened)
        self.integrator = given.setting("integrator")
        self.visibility = given.setting("visibility")
        exact = isinstance(self.visibility, Exact)
        self.use = given.use if given.use is not None or exact else "correct"
        self.renew = None if renew is None else int(renew)
        self._seed, self._spp = int(given.seed), int(given.spp)  # numbers of NumPy overflow
        keeps = (
            isinstance(self.visibility, Aqvc)
            and self.visibility.paper.form == "waves"
            and isinstance(self.integrator, Direct | Whitted)
        )
        if keeps and self.use not in (None, "replace"):
            self.visibility = self.visibility.for_corrected_passes()
        self.rows = AqvcRows(max_bytes=max_bytes) if keeps else None
        self.counts = VoxelCounts() if isinstance(self.visibility, NeePlusPlus) else None
        refines = isinstance(self.visibility, VisMaps) and self.visibility.updates
        self.maps = PassMaps(self.scene, self.visibility, given.rays) if refines else None
        # All passes have the camera and the sky of now
        camera, env = given.camera, given.env
        self._shot = given.with_(
            scene=self.scene,
            visibility=self.visibility,
            use=self.use,
            camera=copy.copy(camera) if isinstance(camera, _core.Camera) else camera,
            env=env if env is None or isinstance(env, Sky) else environment_pixels(env).copy(),
        )
        self._sums = progressive_state.Sums(next_pass=int(first_pass))
        self._turn = Turn("the picture")
        self._lights: tuple[int, _core.KeptLights] | None = None

    @property
    def n_passes(self) -> int:
        """Finished passes."""
        return self._sums.n

    @property
    def is_unbiased(self) -> bool:
        """Whether more passes remove all error but that of lights that stay the same."""
        corrects = self.use not in (None, "replace")
        return corrects or isinstance(self.visibility, Exact | NeePlusPlus)

    def passes(self, n: int, *, show: bool = False, progress: Progress = False) -> Frame:
        """Render n more passes.

        Parameters
        ----------
        n : int >= 0
        show : bool
            In a notebook, show the picture while it gets better.
        progress : bool or callable
            True shows a bar; a callable gets (done, total) in passes.

        Returns
        -------
        Frame
            `frame` after the last pass.

        Raises
        ------
        KeyboardInterrupt
            Finished passes are kept; `passes` goes on with the pass that was interrupted.
        """
        require(is_whole(n) and n >= 0, "n must be a whole number >= 0", n)
        with step_bar(progress, n, unit="pass") as step:
            view = LiveView() if show else None
            for i in range(n):
                self._pass()
                step()
                if view:
                    view.update(self, last=i + 1 == n)
        return self.frame

    def until(
        self,
        *,
        rel_l1: float | None = None,
        seconds: float | None = None,
        passes: int = 1 << 20,
        show: bool = False,
    ) -> Frame:
        """Render passes until the estimated error, the time or their number is reached.

        Parameters
        ----------
        rel_l1 : float > 0, optional
            `error()`, at the earliest after four passes. Not with `use="replace"`, whose error
            passes cannot tell.
        seconds : float > 0, optional
            Wall seconds of this call. The last pass may exceed it, and one pass is made in any
            case.
        passes : int >= 0
            At most so many more passes.
        show : bool
            In a notebook, show the picture while it gets better.

        Returns
        -------
        Frame
            `frame` after the last pass.

        Raises
        ------
        ValueError
            Neither `rel_l1` nor `seconds` is given, or a value is out of range.
        """
        require(
            rel_l1 is not None or seconds is not None,
            "rel_l1 or seconds must be given",
            {"rel_l1": rel_l1, "seconds": seconds},
        )
        for name, value in (("rel_l1", rel_l1), ("seconds", seconds)):
            fits = value is None or (value > 0 and math.isfinite(value))
            require(fits, f"{name} must be > 0 and finite", value)
        require(is_whole(passes) and passes >= 0, "passes must be a whole number >= 0", passes)
        require(
            rel_l1 is None or self.is_unbiased,
            'use must be "correct" for rel_l1, as passes do not tell the error of a cache',
            self.use,
        )
        start, view = time.perf_counter(), LiveView() if show else None
        for _ in range(passes):
            reached = (
                rel_l1 is not None and self.n_passes >= LEAST_PASSES and self.error() <= rel_l1
            )
            out_of_time = seconds is not None and time.perf_counter() - start >= seconds
            if self.n_passes and (reached or out_of_time):
                break
            self._pass()
            if view:
                view.update(self, last=False)
        if view:
            view.update(self, last=True)
        return self.frame

    @property
    def frame(self) -> Frame:
        """The mean of all passes.

        Its layers are those of `vc.render`. "variance" (H, W, 3) is, from the second pass on, the
        variance of the mean's "color" between passes, with all noise in it. Sequences of samples
        go through all passes, so it errs towards more: many times more after many passes.
        Counters of rays and queries and all timings are sums over passes.

        Raises
        ------
        ValueError
            There is no pass.
        """
        return self._frame_of(self._sums)

    def _frame_of(self, sums: progressive_state.Sums) -> Frame:
        require(sums.n > 0, "there must be a pass", sums.n)
        layers = {name: layer.astype(np.float32) for name, layer in sums.means().items()}
        if sums.n > 1:
            layers["variance"] = sums.variance().astype(np.float32)
        return Frame(
            layers=layers,
            counters=dict(sums.counters),
            timings=dict(sums.timings),
            parameters=sums.parameters
            | {"seed": self._seed, "passes": sums.n, "renew": self.renew},
            warnings=list(sums.warnings),
        )

    def error(self) -> float:
        """The estimated `rel_l1_reflected` of the mean, from the noise of passes.

        Noise of eye samples and corrections, not the noise of lights that stay the same, nor the
        error of a cache that is not corrected. At least two passes are needed.

        Notes
        -----
        Two parts of the passes are compared, whose samples are as well spread as those of all; it
        errs towards more, by √3 at most or so. Where lights are renewed, and for `Bdpt`, single
        passes are compared: two parts would tell little of noise that pixels share.
        """
        sums = self._sums
        require(sums.n >= 2, "there must be two passes", sums.n)
        light = light_on_surfaces(self._frame_of(sums))
        assert light is not None
        if self.renew or isinstance(self.integrator, Bdpt):
            deviation = MEAN_DEVIATION * float(np.sqrt(sums.variance()).sum())
        else:
            deviation = float(np.abs(sums.deviation()).sum())
        total = float(np.abs(light).sum())
        return deviation / total if total > 0 else 0.0

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the state: sums of passes, and what caches keep. Complete or absent.

        While another thread renders passes, the state is written between two of them.

        Raises
        ------
        ValueError
            A pass of this thread is going on: `save` was called by a handler of a signal.
        """
        with self._turn:
            progressive_state.save(path, self._shows(), self._sums, self.rows, self._kept_arrays())

    def merge(self, other: Progressive) -> None:
        """Add the passes of another picture, for example one of another machine.

        The bytes of the mean depend on what was merged in which order.

        Raises
        ------
        ValueError
            The other picture has another scene or other settings, or passes that this one has too.
        """
        require(isinstance(other, Progressive), "other must be vc.Progressive(...)", other)
        require_same(self._shows(), other._shows(), "in both")
        with self._turn:
            self._sums = self._sums.merged(other._sums)

    def load(self, path: str | os.PathLike[str]) -> None:
        """Go on from a saved state, which replaces all passes.

        Raises
        ------
        ValueError
            The state belongs to another scene, other settings or another version, or the file is
            damaged. Nothing changes.
        FileNotFoundError
            There is no such file.
        """
        with self._turn:
            self._sums = progressive_state.load(
                path, self._shows(), self.rows, self._restore_arrays
            )

    def _pass(self) -> None:
        with self._turn:
            self._add_pass(self._sums.next_pass)

    def _add_pass(self, n: int) -> None:
        epoch = n // self.renew if self.renew else 0
        alone = isinstance(self.integrator, Bdpt)
        view = {name: getattr(self._shot, name) for name in ("camera", "size", "threads")}
        drawn, use, memory = self._drawn()
        refined = self.maps.for_pass(n, **view) if self.maps else nullcontext(drawn)
        with refined as visibility:
            kept = self.rows if self.rows is not None else self.counts
            seed = seed_of(self._seed, "pass" if alone else "lights", n if alone else epoch)
            frame = render_part(
                self._shot.with_(visibility=visibility, use=use, seed=seed),
                first_sample=0 if alone else n * self._spp,
                keep=kept if drawn is self.visibility else None,
                memory=None if alone else memory,
            )
        if self.use != use and isinstance(visibility, Exact):
            frame.counters["exact_queries"] = frame.counters["queries"]
        if self.maps is not None:
            frame.counters.update(self.maps.counters)
            frame.timings["records_s"] += self.maps.seconds
        self._sums = self._sums.plus(frame, n)

    def _learn(self) -> None:
        """Decides how later passes draw, once the first ones tell."""
        sums = self._sums
        if sums.shares is not None or sums.n == 0:
            return
        use = self.use if isinstance(self.use, Correct) else Correct()
        kept = self.rows is not None and not self.renew
        shares = shares_after(
            sums.n, sums.squares, sums.layers, sums.counters, use, rows_are_kept=kept
        )
        warnings = sums.warnings
        if shares is not None and math.isinf(shares.scale):
            warnings = [
                *warnings,
                f"exact visibility from pass {sums.n + 1} on: the noise of corrections would cost "
                'more than they save; vc.Correct(certain=...) or use="replace" keeps the cache',
            ]
        self._sums = dataclasses.replace(sums, shares=shares, warnings=warnings)

    def _drawn(self) -> tuple[Any, Any, PassMemory]:
        """Visibility, use and memory of the next pass.

        Draws of the first passes decide the shares of all others, which therefore draw
        independently of them.
        """
        epoch = self._sums.next_pass // self.renew if self.renew else 0
        if self._lights is None or self._lights[0] != epoch:
            self._lights = (epoch, _core.KeptLights())
        lights = self._lights[1]
        self._learn()
        shares = self._sums.shares
        if self._all_is_exact() or (shares is not None and math.isinf(shares.scale)):
            return Exact(), None, PassMemory(lights)
        if shares is None:
            return self.visibility, self.use, PassMemory(lights)
        use = self.use
        if shares.scale != 1:
            given = use if isinstance(use, Correct) else Correct()
            use = dataclasses.replace(given, certain=CERTAIN / shares.scale)
        return self.visibility, use, PassMemory(lights, shares.octaves, 1)

    def _all_is_exact(self) -> bool:
        """Whether the passes so far asked for no light that the cache answers."""
        counters = self._sums.counters
        exact = counters.get("exact_queries", 0)
        same_lights = self.rows is not None and not self.renew
        return same_lights and 0 < exact == counters["queries"]

    def _kept_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """What counts and maps keep, for a file."""
        kept = self.counts if self.counts is not None else self.maps
        return kept._state() if kept is not None else {}

    def _restore_arrays(self, state: dict[str, npt.NDArray[Any]]) -> None:
        if self.counts is not None:
            self.counts._restore(self.scene, self.visibility, state)
        elif self.maps is not None:
            self.maps._restore(state)

    def _shows(self) -> dict[str, Any]:
        """What a saved state, or a picture to merge, must agree with."""
        return {**self._shot.parts, "renew": self.renew}

    def _repr_html_(self) -> str:
        if not self.n_passes:
            return f"<p>{self!r}</p>"
        frame = self.frame
        return frame_html(frame.image, frame.timings, frame.counters)

    def __repr__(self) -> str:
        return f"Progressive({self.scene.name!r}, {self.n_passes} passes)"
