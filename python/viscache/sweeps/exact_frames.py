"""Exact frames, rendered once and kept in a folder by the hash of all that determines them."""

from __future__ import annotations

import os
import re
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from viscache.base.array_digests import content_key
from viscache.base.files import inside, write_whole
from viscache.base.progress import Progress
from viscache.base.provenance import code_hash, embree_version, isa
from viscache.frame import Frame
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.scenes import sources
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import Integrator
from viscache.settings.spelling import spelled
from viscache.shot.render import render_part
from viscache.shot.shot import BareShot, ShotArguments, of_shot
from viscache.sweeps.leases import LostLeaseError
from viscache.sweeps.plan import positive
from viscache.sweeps.store import DATABASE_FILES, Store

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: Frames of other code that were not used for so long are removed.
KEPT_S = 30 * 24 * 3600.0
#: Name and content of the file that tells folders of exact frames from all others; its time is that
#: of the last use.
MARKER = "exact-frames"
MARK = b"Exact frames of viscache. Their files are removed if they are not used for 30 days.\n"
#: Names of pictures, and of those that killed processes left half written.
_PICTURES = re.compile(r"[0-9a-f]{20}\.exr|\.[0-9a-f]{20}\.exr\..+\.part")
#: Seconds between looks at a frame that another process renders.
POLL_S = 0.05


class ExactFrames:
    """A function that renders exact frames and keeps them in a folder.

    A frame is found by the content of its scene and environment, integrator, rays, camera, size,
    samples and seed, and by the code of viscache, the version of Embree and the instruction set.
    So it is never one that would be rendered otherwise today. What is read is checked by its hash;
    a damaged frame is rendered again. Processes that share the folder render each frame once: the
    others wait for it. Frames of other code are removed after 30 days without use; all else in the
    folder stays.

    Parameters
    ----------
    directory : path, optional
        Created with the first frame. None: nothing is kept.

    Examples
    --------
    >>> import tempfile, viscache as vc
    >>> exact = vc.testing.ExactFrames(tempfile.mkdtemp())
    >>> scene = vc.scenes.cube_on_plane()
    >>> first = exact(scene, vc.Direct(), size=(32, 20))
    >>> again = exact(scene, vc.Direct(), size=(32, 20))  # read, not rendered
    >>> again.sha256 == first.sha256 == vc.render(scene, vc.Direct(), size=(32, 20)).sha256
    True
    """

    def __init__(self, directory: str | os.PathLike[str] | None) -> None:
        self.directory = None if directory is None else Path(directory)

    def __repr__(self) -> str:
        return f"ExactFrames({None if self.directory is None else str(self.directory)!r})"

    @spelled
    @of_shot("visibility", "use")
    def __call__(
        self,
        scene: Scene | str | os.PathLike[str],
        integrator: Integrator | str | None = None,
        *,
        progress: Progress = False,
        **shot: Unpack[ShotArguments],
    ) -> Frame:
        """An exact frame; parameters as of `viscache.render`.

        Timings are those of its rendering. Each call returns a frame of its own, which the caller
        may change.

        Raises
        ------
        ValueError
            As `viscache.render`.
        """
        given = BareShot(scene, integrator, **shot)
        fits = is_whole(given.seed) and 0 <= given.seed < 1 << 63
        require(fits, "seed must be in [0, 2^63)", given.seed)
        lit, spp = sources.opened(given.opened), positive("spp", given.spp)
        size = frame_size(given.size, find_camera(lit, given.camera))
        wanted = given.with_(scene=lit, size=size, spp=spp, seed=int(given.seed))
        if self.directory is None:
            return render_part(wanted, progress=progress)
        with Store(_room(self.directory)) as store:
            return _once(store, wanted, progress)


def _once(store: Store, shot: BareShot, progress: Progress) -> Frame:
    """The frame of a store; one process renders it, the others wait."""
    key = shot.key
    while (found := _kept(store, key)) is None:
        if not store.leases.claim(key):
            store.leases.wait(POLL_S)
            continue
        try:
            found = _kept(store, key)  # finished by another process before the claim
            if found is None:
                found = render_part(shot, progress=progress)
                with suppress(LostLeaseError):  # another process keeps it: this one has the same
                    store.put(key, shot.parts, found)
            return found
        finally:
            store.leases.release(key)
    return found


def _kept(store: Store, key: str) -> Frame | None:
    """The frame of a key if it is there and as it was written."""
    try:
        return store.frame(key)
    except (KeyError, OSError, ValueError):
        return None


def _room(directory: Path) -> Path:
    """The folder of this code, Embree and instruction set; old frames of others are removed."""
    here = content_key({"code": code_hash(), "embree": embree_version(), "isa": isa()[0]})[:16]
    room, marker = inside(directory, here), inside(directory, f"{here}/{MARKER}")
    if not marker.is_file():
        room.mkdir(parents=True, exist_ok=True)
        write_whole(marker, MARK.decode())
        for other in directory.iterdir():
            _remove_unused(directory, other.name)
    os.utime(marker)
    return room


def _remove_unused(directory: Path, name: str) -> None:
    """Remove exact frames that were not used for long; what else is in their folder stays."""
    try:
        marker, frames = (inside(directory, f"{name}/{file}") for file in (MARKER, "frames"))
        if time.time() - marker.stat().st_mtime < KEPT_S or marker.read_bytes() != MARK:
            return
        old = [picture for picture in frames.iterdir() if _PICTURES.fullmatch(picture.name)]
        old += [marker.with_name(f"sweep.sqlite{end}") for end in DATABASE_FILES]
        for file in (*old, marker):
            file.unlink(missing_ok=True)
    except (OSError, ValueError):  # another folder or file, links, or another process was faster
        return
    for folder in (frames, marker.parent):
        with suppress(OSError):  # it holds something else
            folder.rmdir()
