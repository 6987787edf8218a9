"""Sweeps: render over a grid of parameters, measure every frame against its references.

There are two references per point. *Paired*: the same integrator, seed and samples with exact
visibility, so the difference is the error of the cache alone. *Converged* (optional): another seed
and many samples, so the difference is the total error. Both are rendered once and kept.
"""

from __future__ import annotations

import inspect
import json
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from viscache import metrics as _metrics
from viscache.base.progress import Progress
from viscache.oracles.correct import check_use
from viscache.oracles.written import is_written
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.scenes import sources
from viscache.settings import by_name
from viscache.settings.checks import is_whole, require
from viscache.settings.spelling import nearest, spelled
from viscache.shot.shot import BareShot, ShotArguments, of_shot
from viscache.sweeps import designs
from viscache.sweeps.plan import Over, definition_of, make_plan, positive
from viscache.sweeps.run import Run
from viscache.sweeps.store import Store
from viscache.sweeps.table import to_dataset, write_table

if TYPE_CHECKING:
    import xarray
    from typing_extensions import Unpack

DEFAULT_METRICS = ("rel_l1", "rel_l1_reflected", "rmse", "energy", "flip", "ssim")


@spelled
@of_shot(visibility="aqvc")
def sweep(
    scene: Any,
    integrator: Any = None,
    *,
    over: Over,
    repeats: int = 1,
    converged: Mapping[str, int] | None = None,
    metrics: Iterable[str] = DEFAULT_METRICS,
    directory: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    apart: bool | None = None,
    references: str | os.PathLike[str] | None = None,
    progress: Progress = False,
    **shot: Unpack[ShotArguments],
) -> xarray.Dataset:
    """Render every setting of a grid and measure it against its references.

    Parameters
    ----------
    scene, integrator, rays, use, size, spp, threads, camera, env
        What to render: see `viscache.Shot`.
    visibility : settings or str, optional
        The cache whose parameters are swept; `vc.Aqvc()` by default.
    over : mapping of name to values, or a list of points
        A grid `{"c_e": [4, 8], "integrator.n_vpls": [256, 1024]}`, or points
        `[{"c_e": 4, "c_n": 8}, ...]` that all have the same names. A bare name is the visibility's
        parameter (`visibility.c_e` is the same); `integrator.` and `rays.` reach the others. In a
        grid, `{"log": [2, 32], "n": 9}` or `{"linear": [4, 32], "n": 8, "whole": True}` stands for
        a list; `viscache.designs` draws random points and Latin hypercubes.
    repeats, seed : int
        Repeat i uses seed + i, as the table says, so sweeps whose seeds overlap share frames.
        1 <= repeats.
    converged : {"spp": ..., "seed": ...}, optional
        Renders the second reference, of all lights also where the integrator picks some.
    metrics : iterable of str
        Names of `viscache.metrics.METRICS`.
    directory : path, optional
        Directory of the store. An interrupted sweep resumes there and repeats nothing. Without it
        only the table is kept.
    executor : concurrent.futures.Executor, optional
        Renders frames in threads, processes or dask's workers; this process compares and stores
        them. Every worker loads a `scene` that has a spec once. Other scenes are sent with their
        arrays.
    apart : bool, optional
        Never render two frames at a time on this machine, for any executor and any number of
        processes that use the directory, because they would disturb each other's timings. By
        default True without an executor and False with one. `alone` in the table tells it for
        each point.
    references : path, optional
        A directory of finished references that several sweeps share.
    progress : bool or callable
        A bar with the time left on standard error, or a function of (done, total).

    Returns
    -------
    xarray.Dataset
        Dims: the swept names (last part of the dotted name; `point` for a list of points) and
        `repeat`. Variables: the metrics against the paired reference, `converged_*` against the
        converged one, rays, queries, ray_reduction, total_s (without building the ray caster, which
        only the first frame pays), visibility_s, cpu_s, exact_total_s, speedup (of total_s against
        the paired exact frame), cpu_speedup (the same of cpu_s, which other load on the machine
        disturbs less), alone (1: no frame of the sweep ran beside it), and `*_by_group` on
        `group`. Where they went, the attribute `seconds` says: wall seconds of frames, metrics,
        the store, and in total.

    Raises
    ------
    ValueError
        Unknown names (the message has the nearest known one), empty lists, bad values.
    KeyboardInterrupt
        Ctrl-C was pressed; finished frames are kept.
    """
    given = BareShot(scene, integrator, **shot)
    cache, seed = given.setting("visibility"), given.seed
    require(not is_written(cache) or is_dataclass(cache), "visibility must be a dataclass", cache)
    check_use(given.use)
    require(is_whole(seed) and 0 <= seed < 1 << 63, "seed must be in [0, 2^63)", seed)
    source = os.fspath(scene) if isinstance(scene, os.PathLike) else scene
    opened = given.opened
    view = find_camera(opened, given.camera) if given.size is None else None
    size = frame_size(given.size, view)
    base = given.with_(scene=opened, size=size, spp=positive("spp", given.spp), seed=int(seed))
    plan = make_plan(
        base,
        source,
        over=over,
        repeats=positive("repeats", repeats),
        converged=converged,
        metrics=_metrics.check_names(metrics),
    )
    with Store(directory) as store:
        store.define(definition_of(plan, base, source, converged))
        with nullcontext() if references is None else Store(references) as shared:
            one_by_one = executor is None if apart is None else bool(apart)
            run = Run(plan, store, opened, progress, apart=one_by_one, references=shared)
            run.go(executor)
        dataset = to_dataset(plan.names, store)
        if store.directory is not None:
            write_table(dataset, store.directory / "table.nc")
    if run.mended:
        dataset.attrs["mended"] = "\n".join(run.mended)
    dataset.attrs["seconds"] = json.dumps({k: round(v, 3) for k, v in run.seconds.items()})
    return dataset


@spelled
@dataclass(frozen=True, kw_only=True, slots=True)
class SweepFile:
    """A sweep written down in TOML.

    Parameters
    ----------
    scene : str
        A built-in name, or a path relative to the file.
    over : grid or list of points
        `[over]`, or `points = [{c_e = 4, c_n = 8}, ...]`; exactly one of the two. In `[over]`,
        `c_e = {log = [2, 32], n = 9}` or `{linear = [4, 32], n = 8, whole = true}` are ranges.
    design : table, optional
        `{kind = "latin_hypercube", n = 50, seed = 0}` or `kind = "random"`: that many points drawn
        from the lists and ranges (without n) of `[over]`, instead of its grid.
    integrator, visibility, rays : str or table
        A name, or a table with fixed parameters: `{name = "whitted", n_vpls = 1024}`; a `preset` in
        a table is applied first.
    preset : str, optional
        Preset of the visibility, where it is only a name.
    folder : path, optional
        What a relative scene or environment is relative to.
    missing : {"error", "skip"}
    allow_outside : bool
        How the scene's file is read, as `load_scene` takes them.
    title, use, camera, env, size, spp, repeats, seed, converged, metrics, threads
        As `sweep` takes them.
    """

    scene: str
    over: Over
    design: Mapping[str, Any] | None = None
    integrator: str | Mapping[str, Any] = "whitted"
    visibility: str | Mapping[str, Any] = "aqvc"
    rays: str | Mapping[str, Any] = "embree"
    preset: str | None = None
    missing: Literal["error", "skip"] = "error"
    allow_outside: bool = False
    title: str = ""
    use: str | None = None
    camera: str | None = None
    env: str | float | None = None
    size: Sequence[int] | None = None
    spp: int = 1
    repeats: int = 1
    seed: int = 0
    converged: Mapping[str, int] | None = None
    metrics: Sequence[str] = DEFAULT_METRICS
    threads: int | None = None
    folder: Path | None = field(default=None, repr=False)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> SweepFile:
        """Read a file; ValueError names the file and what is wrong, with the nearest known name."""
        if sys.version_info >= (3, 11):
            import tomllib
        else:
            import tomli as tomllib

        source = Path(path)
        try:
            with source.open("rb") as file:
                table = tomllib.load(file)
        except FileNotFoundError as error:
            raise ValueError(f"no such sweep file: {source}") from error
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ValueError(f"{source}: {error}") from error
        try:
            return cls.from_table(table, folder=source.parent)
        except ValueError as error:
            raise ValueError(f"{source}: {error}") from error

    @classmethod
    def from_table(cls, table: Mapping[str, Any], *, folder: Path | None = None) -> SweepFile:
        """From what TOML holds; unknown keys are refused with the nearest known one."""
        known = [f.name for f in fields(cls) if f.name != "folder"] + ["points"]
        for name in table:
            if name not in known:
                raise ValueError(f"unknown key {name!r}{nearest(name, known)}")
        if "scene" not in table:
            raise ValueError("a sweep must name a scene")
        if ("over" in table) == ("points" in table):
            raise ValueError("a sweep must have either [over] or points")
        rest = {name: value for name, value in table.items() if name != "points"}
        rest["over"] = table.get("over", table.get("points"))
        _check_types(rest)
        if isinstance(rest["over"], Mapping):
            rest["over"] = _flat(rest["over"])
        if "design" in rest:
            rest["over"] = designs.draw(rest["design"], rest["over"])
        return cls(**rest, folder=folder)

    def run(
        self,
        directory: str | os.PathLike[str] | None,
        *,
        executor: Executor | None = None,
        apart: bool | None = None,
        references: str | os.PathLike[str] | None = None,
        progress: Progress = False,
    ) -> xarray.Dataset:
        """Run or resume the sweep in a directory; see `sweep`."""
        visibility = self.visibility
        if self.preset is not None:
            table = {"name": visibility} if isinstance(visibility, str) else dict(visibility)
            visibility = {"preset": self.preset, **table}
        env = sources.absolute(self.env, self.folder) if isinstance(self.env, str) else self.env
        same = [name for name in inspect.signature(sweep).parameters if hasattr(self, name)]
        given = {name: getattr(self, name) for name in same}
        given |= {"scene": self._scene(), "visibility": visibility, "env": env}
        return sweep(
            **given,
            directory=directory,
            executor=executor,
            apart=apart,
            references=references,
            progress=progress,
        )

    def _scene(self) -> str | Scene:
        """The scene's spec, by which workers load it; with options, the scene itself."""
        spec = sources.absolute(self.scene, self.folder)
        if self.missing == "error" and not self.allow_outside:
            return spec
        return sources.open_scene(spec, missing=self.missing, allow_outside=self.allow_outside)


_TYPES: dict[str, tuple[type, ...]] = {
    "scene": (str,),
    "integrator": (str, Mapping),
    "visibility": (str, Mapping),
    "rays": (str, Mapping),
    "preset": (str,),
    "missing": (str,),
    "allow_outside": (bool,),
    "title": (str,),
    "use": (str,),
    "camera": (str,),
    "env": (str, int, float),
    "size": (list,),
    "spp": (int,),
    "repeats": (int,),
    "seed": (int,),
    "converged": (Mapping,),
    "metrics": (list,),
    "threads": (int,),
    "over": (Mapping, list),
    "design": (Mapping,),
}


def _check_types(table: Mapping[str, Any]) -> None:
    words = {
        str: "a string",
        Mapping: "a table",
        list: "a list",
        int: "an integer",
        float: "a number",
        bool: "true or false",
    }
    for name, value in table.items():
        # In Python, true and false are integers too
        if not isinstance(value, _TYPES[name]) or isinstance(value, bool) != (bool in _TYPES[name]):
            what = " or ".join(words[t] for t in _TYPES[name])
            raise ValueError(f"{name} must be {what}, got {value!r}")
    points = table["over"]
    if isinstance(points, list) and not all(isinstance(p, Mapping) for p in points):
        raise ValueError(f"points must be a list of tables, got {points!r}")


def _flat(over: Mapping[str, Any]) -> dict[str, Any]:
    """TOML reads the bare key `integrator.n_vpls` as a table in a table; both are meant."""
    flat: dict[str, Any] = {}
    for name, value in over.items():
        if isinstance(value, Mapping) and name in by_name.ROLES:
            flat |= {f"{name}.{inner}": values for inner, values in value.items()}
        else:
            flat[name] = value
    return flat
