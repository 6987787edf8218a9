"""Pictures of HTML pages that viscache writes, as Debian's chromium shows them."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image

import viscache as vc

#: Names of the program.
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
#: Milliseconds of the page's own clock in which it unpacks its pictures.
UNTIL_SHOWN_MS = 20_000


def report() -> Any:
    """The head of a sweep's report: the verdict, the trade, and heat maps."""
    with tempfile.TemporaryDirectory() as folder:
        vc.sweep(
            "room?triangles=20000",
            vc.Whitted(n_vpls=1024),
            over={"c_e": [2, 4, 8, 16, 32], "c_n": [2, 8]},
            size=(480, 300),
            metrics=["rel_l1"],
            directory=folder,
        )
        path = vc.report.write(folder, target=0.02)
        return shown(path, (1100, 1050))


def failed_test() -> Any:
    """The page of a failed `assert_close`."""
    scene, size = "stairs", (240, 150)
    frame = vc.render(scene, "direct", size=size, visibility=vc.Aqvc(c_e=4, exact_groups=()))
    exact = vc.render(scene, "direct", size=size)
    try:
        vc.testing.assert_close(frame, exact, rel_l1=0.001)
    except vc.testing.PictureError as error:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "diff.html")
            error.write(path)
            return shown(path, (1100, 700))
    raise RuntimeError("the frames must differ")


def shown(page: Path, size: tuple[int, int]) -> Image.Image:
    """A page from its top, in a window of such size."""
    program = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if program is None:
        raise RuntimeError(f"one of {', '.join(BROWSERS)} must be installed")
    picture = page.with_suffix(".png")
    command = [
        program,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        "--no-first-run",
        "--host-resolver-rules=MAP * ~NOTFOUND",
        f"--user-data-dir={page.parent / 'profile'}",
        f"--window-size={size[0]},{size[1]}",
        f"--virtual-time-budget={UNTIL_SHOWN_MS}",
        f"--screenshot={picture}",
        page.as_uri(),
    ]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    return Image.open(picture).convert("RGB")


PICTURES: dict[str, Callable[[], Any]] = {"how-report": report, "how-pytest": failed_test}
