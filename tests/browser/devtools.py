"""A headless chromium driven by its DevTools protocol over pipes; the standard library suffices."""

import base64
import io
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np

CHROMIUM = next(
    (c for c in ("chromium", "chromium-browser", "google-chrome") if shutil.which(c)), ""
)
TIMEOUT_S = 60.0


class Browser:
    """One tab. What the page throws, or writes into the console, is in `errors`."""

    def __init__(self, profile: Path, width: int = 1200, height: int = 1000) -> None:
        command = [
            CHROMIUM,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            f"--user-data-dir={profile}",
            f"--window-size={width},{height}",
            "--no-first-run",
            "--host-resolver-rules=MAP * ~NOTFOUND",
            "--disable-background-networking",
            "--disable-sync",
            "--remote-debugging-pipe",
            "about:blank",
        ]
        to_read, self._write = os.pipe()
        self._read, to_write = os.pipe()

        def wire() -> None:  # the browser reads commands from 3 and answers on 4
            os.dup2(os.dup(to_read), 103)
            os.dup2(os.dup(to_write), 104)
            os.dup2(103, 3)
            os.dup2(104, 4)

        self._process = subprocess.Popen(
            command,
            preexec_fn=wire,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self._buffer = b""
        self._count = 0
        self._session = ""
        self.errors: list[str] = []
        target = next(
            t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page"
        )
        attached = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.size(width, height)

    def close(self) -> None:
        self._process.terminate()
        self._process.wait(20)
        os.close(self._write)
        os.close(self._read)

    def size(self, width: int, height: int, phone: bool = False, dark: bool = False) -> None:
        """Set the window's size and the system's colour scheme."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=2 if phone else 1,
            mobile=phone,
        )
        self.call("Emulation.setTouchEmulationEnabled", enabled=phone)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])

    def open(self, page: Path, fragment: str = "") -> None:
        """Load a report and wait until it shows its pictures."""
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=f"{page.as_uri()}#{fragment}")
        self.wait_for("document.readyState === 'complete'")

    def eval(self, expression: str):
        """The value of a JavaScript expression; a promise is awaited."""
        got = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in got:
            raise AssertionError(f"{expression}: {got['exceptionDetails']}")
        return got["result"].get("value")

    def wait_for(self, condition: str) -> None:
        end = time.monotonic() + TIMEOUT_S
        while not self.eval(condition):
            assert time.monotonic() < end, f"still not so: {condition}; errors: {self.errors}"
            time.sleep(0.05)

    def text(self, element: str) -> str:
        return str(self.eval(f"document.getElementById('{element}').textContent"))

    def box(self, element: str) -> tuple[float, float, float, float]:
        """Left, top, width and height of an element, after scrolling to it."""
        bounds = (
            "(e => { e.scrollIntoView({block: 'center'}); const b = e.getBoundingClientRect();"
            " return [b.left, b.top, b.width, b.height] })"
        )
        return tuple(self.eval(f"{bounds}(document.getElementById('{element}'))"))

    def mouse(self, kind: str, x: float, y: float, **more) -> None:
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        held = {"button": "left", "buttons": 1, "clickCount": 1}
        self.mouse("mousePressed", *begin, **held)
        for share in (0.5, 1.0):
            x, y = (b + share * (e - b) for b, e in zip(begin, end, strict=True))
            self.mouse("mouseMoved", x, y, **held)
        self.mouse("mouseReleased", *end, button="left", clickCount=1)

    def key(self, key: str, shift: bool = False) -> None:
        """A key's name or the letter it writes."""
        text = {"text": key} if len(key) == 1 else {}
        more = {"key": key, "code": key, "modifiers": 8 if shift else 0}
        self.call("Input.dispatchKeyEvent", type="keyDown", **more, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", **more)

    def screenshot(self, element: str | None = None) -> np.ndarray:
        """(H, W, 3) pixels of an element, or of the whole page."""
        from PIL import Image

        clip = {}
        if element is not None:
            left, top, width, height = self.box(element)
            x, y = self.eval("[scrollX, scrollY]")
            clip = {
                "clip": {"x": left + x, "y": top + y, "width": width, "height": height, "scale": 1}
            }
        got = self.call("Page.captureScreenshot", captureBeyondViewport=True, **clip)
        with Image.open(io.BytesIO(base64.b64decode(got["data"]))) as image:
            return np.asarray(image.convert("RGB"), dtype=int)

    def call(self, method: str, **parameters):
        """The result of a command; earlier events are processed first."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            got = self._receive()
            if got.get("id") == self._count:
                assert "error" not in got, f"{method}: {got['error']}"
                return dict(got["result"])
            self._look_at(got)

    def _look_at(self, event) -> None:
        method, given = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.errors.append(json.dumps(given["exceptionDetails"]))
        elif method == "Log.entryAdded":
            self.errors.append(given["entry"]["text"])
        elif method == "Runtime.consoleAPICalled":
            self.errors.append(json.dumps(given["args"]))
        elif method == "Network.requestWillBeSent":
            url = given["request"]["url"]
            if not url.startswith(("file:", "data:", "about:", "blob:")):
                self.errors.append(f"asked for {url}")

    def _receive(self):
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._read], [], [], TIMEOUT_S)
            assert ready, "the browser does not answer"
            more = os.read(self._read, 1 << 20)
            assert more, "the browser has ended"
            self._buffer += more
        line, _, self._buffer = self._buffer.partition(b"\0")
        return dict(json.loads(line))
