"""Every reader of files, and a whole file for it to start from."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenEXR

import viscache as vc
from base.kept_formats import KEPT, measured, swept, two_frames
from base.kept_formats import picture as kept_picture
from fuzz.calls_render import checked, in_json
from fuzz.outcome import WrongError
from viscache import _core as core
from viscache.sweeps.flip_maps import kept

#: Small whole files of every format, by kind.
CORPUS = Path(__file__).with_name("corpus")
SIZE = (6, 5)
QUICK = vc.Whitted(n_vpls=4, n_area=1, n_environment=1, n_brdf=1)


@dataclass(frozen=True)
class Reader:
    """Whole files, and what reads each of them."""

    seeds: Callable[[Path], list[Path]]  #: makes whole files in a folder
    read: Callable[[Path], object]  #: of a file that was changed, or of its folder
    in_place: bool = False  #: the file keeps its name in a copy of the folder "whole"


def rendered(scene: vc.Scene) -> None:
    """What a scene from a file must be able to: bounds, info, a finite frame."""
    if scene.triangles:
        in_json(scene.info())  # the bounds among it
    checked(vc.render(scene, QUICK, size=SIZE, camera=0 if scene.cameras else None, threads=1))


def load(path: Path) -> None:
    """A scene file."""
    rendered(vc.load_scene(path, threads=1))


def materials(path: Path) -> None:
    """The materials of an OBJ file beside them."""
    scene = path.with_suffix(".obj")
    lines = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1 3 2\n"
    scene.write_text(f"mtllib {path.name}\n{lines}")
    load(scene)


def picture(path: Path) -> None:
    """A picture, as textures and skies read it."""
    if not np.isfinite(core.read_image(str(path))).all():
        raise WrongError("a pixel is not finite")


def sky(path: Path) -> None:
    """A picture as environment."""
    rendered(vc.scenes.cube_on_plane().with_environment(str(path), threads=1))


def frame(path: Path) -> None:
    """A saved frame."""
    found = vc.Frame.load(path)
    found.summary(), found.sha256


def cache(path: Path) -> None:
    """Saved visibility maps, used for a frame."""
    scene = vc.scenes.cube_on_plane()
    found = vc.VisibilityMapCache.load(path, scene)
    found.update(size=SIZE, threads=1)
    if len(found.lookup([[0, 0, 0]], [[0, 1, 0]], 1.0).beta) != 1:
        raise WrongError("a look-up has one row for each point")


def state(path: Path) -> None:
    """The state of a progressive picture, which then goes on."""
    made = kept_picture()
    made.load(path)
    checked(made.passes(1))
    made.error(), made.save(path)


def pair_table(path: Path) -> None:
    """A saved table of pairs, added to itself."""
    found = vc.correlation.pairs.PairTable.from_npz(path)
    found + found


def dataset(path: Path) -> None:
    """A saved correlation."""
    vc.correlation.correlation_lengths(vc.correlation.load_dataset(path))


def sweep_file(path: Path) -> None:
    """A sweep described in TOML; it does not run."""
    from viscache.sweeps.sweep import SweepFile

    SweepFile.load(path)


def corpus(kind: str) -> Callable[[Path], list[Path]]:
    """Copies of the small files of a kind."""

    def make(folder: Path) -> list[Path]:
        shutil.copytree(CORPUS / kind, folder, dirs_exist_ok=True)
        return sorted(folder.iterdir())

    return make


def correlated(folder: Path) -> None:
    """A correlation that keeps its blocks in a folder."""
    measured(directory=folder)


def saved(name: str, within: str = "") -> Callable[[Path], list[Path]]:
    """A file of a format that is read back."""

    def make(folder: Path) -> list[Path]:
        (folder / within).mkdir(exist_ok=True)
        return [KEPT[name].make(folder / within)]

    return make


def stored(run: Callable[[Path], object]) -> Callable[[Path], list[Path]]:
    """The small files of a folder that a run keeps."""

    def make(folder: Path) -> list[Path]:
        run(folder / "whole")
        files = sorted(path for path in (folder / "whole").rglob("*") if path.is_file())
        return [path for path in files if path.stat().st_size < 1 << 16]

    return make


def save_sky(folder: Path) -> list[Path]:
    pixels = {c: np.random.default_rng(1).random((8, 16), dtype=np.float32) for c in "RGB"}
    head = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(head, pixels).write(str(folder / "sky.exr"))
    return [folder / "sky.exr"]


def flip_map(folder: Path) -> None:
    """A FLIP map that is kept in the folder of a sweep; a damaged one is none.

    It is not measured: threads of FLIP do not come back in forked children.
    """
    frames = two_frames()
    found = kept(frames[0], frames[1], folder)
    if found is not None and found.errors.shape != frames[0].image.shape[:2]:
        raise WrongError("it has another size")


def save_sweep(folder: Path) -> list[Path]:
    (folder / "sweep.toml").write_text(
        'scene = "cube_on_plane"\nintegrator = "direct"\nsize = [8, 8]\nrepeats = 2\nseed = 1\n'
        'metrics = ["rel_l1"]\n[over]\nc_e = [4, 8]\nc_n = {log = [2, 8], n = 3}\n'
    )
    return [folder / "sweep.toml"]


READERS = {
    **{kind: Reader(corpus(kind), load) for kind in ("obj", "ply", "gltf", "glb", "pbrt", "xml")},
    "serialized": Reader(corpus("serialized"), load),
    "mtl": Reader(corpus("mtl"), materials),
    **{kind: Reader(corpus(kind), picture) for kind in ("png", "jpg", "hdr", "bmp", "tga")},
    "sky.exr": Reader(save_sky, sky),
    "frame.exr": Reader(saved("frame"), frame),
    "cache.npz": Reader(saved("maps"), cache),
    "dataset.nc": Reader(saved("dataset"), dataset),
    "pairs.npz": Reader(saved("pair table"), pair_table),
    "flip map": Reader(saved("flip map", "whole"), flip_map, in_place=True),
    "sweep": Reader(stored(swept), swept, in_place=True),
    "correlation": Reader(stored(correlated), correlated, in_place=True),
    "state.npz": Reader(saved("state"), state),
    "sweep.toml": Reader(save_sweep, sweep_file),
}
