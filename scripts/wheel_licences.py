"""Put the licences of all that a repaired wheel contains into it: wheel_licences.py WHEEL.

The libraries that auditwheel copied are found by their Debian package, and so are the headers that
are compiled in. Each gets the file that Debian keeps of it. The text of Apache-2.0, which some of
them name, is that of viscache itself.
"""

from __future__ import annotations

import base64
import hashlib
import re
import subprocess
import sys
import zipfile
from importlib import metadata
from pathlib import Path

#: Headers compiled in, as there are no libraries of them.
HEADERS = (
    "tiny_obj_loader.h",
    "tiny_gltf.h",
    "nlohmann/json.hpp",
)


def owner(path: Path) -> str:
    """Return the Debian package of a file."""
    tries = [str(path), str(path).removeprefix("/usr")]
    for name in tries:
        found = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True, check=False)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    raise SystemExit(f"{path} belongs to no Debian package: its licence is not known")


def libraries(wheel: zipfile.ZipFile) -> list[Path]:
    """Files of the system that the wheel's libraries were copied from."""
    cache = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=True).stdout
    places = dict(re.findall(r"^\s*(\S+) \(.*\) => (\S+)$", cache, re.M))
    found = []
    for name in wheel.namelist():
        if not (match := re.match(r"viscache\.libs/(.+)-[0-9a-f]{8}(\.so[.0-9]*)$", name)):
            continue
        stem, version = match[1], match[2]
        fitting = [
            Path(place).resolve()
            for soname, place in places.items()
            if soname.split(".so")[0] == stem and (stem + version).startswith(soname)
        ]
        if not fitting:
            raise SystemExit(f"{name}: there is no such library on this system")
        found.append(fitting[0])
    if not found:
        raise SystemExit("the wheel has no libraries inside: was it repaired?")
    return found


def headers() -> list[Path]:
    """Headers that are compiled in; those of other places than the system's have no package."""
    places = [Path("/usr/include") / name for name in HEADERS]
    if missing := [str(place) for place in places if not place.exists()]:
        raise SystemExit(f"not found: {', '.join(missing)}")
    return [place.resolve() for place in places]


def texts(wheel: zipfile.ZipFile) -> dict[str, bytes]:
    """Licence by the name of its package."""
    packages = sorted({owner(path) for path in libraries(wheel) + headers()})
    found = {name: Path(f"/usr/share/doc/{name}/copyright").read_bytes() for name in packages}
    licences = [f for f in metadata.files("pybind11") or [] if f.name.upper().startswith("LICENSE")]
    found["pybind11"] = licences[0].read_binary()
    return found


def row(name: str, data: bytes) -> str:
    """Return the line of RECORD of a file."""
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}"


def main() -> int:
    """Rewrite the wheel with the licences inside."""
    path = Path(sys.argv[1])
    with zipfile.ZipFile(path) as wheel:
        entries = {info: wheel.read(info) for info in wheel.infolist()}
        added = texts(wheel)
    record = next(info for info in entries if info.filename.endswith(".dist-info/RECORD"))
    info = record.filename.removesuffix("/RECORD")
    files = {f"{info}/licenses/bundled/{name}.txt": text for name, text in added.items()}
    described = next(entry for entry in entries if entry.filename == f"{info}/METADATA")
    lines = "".join(f"License-File: bundled/{name}.txt\n" for name in added).encode()
    entries[described] = entries[described].replace(b"License-File:", lines + b"License-File:", 1)
    rows = entries[record].decode().splitlines()
    rows = [line for line in rows if not line.startswith(f"{described.filename},")]
    rows += [row(described.filename, entries[described])]
    rows += [row(name, text) for name, text in files.items()]
    entries[record] = ("\n".join(rows) + "\n").encode()

    fresh = path.with_suffix(".part")
    with zipfile.ZipFile(fresh, "w", zipfile.ZIP_DEFLATED) as wheel:
        for entry, data in entries.items():
            wheel.writestr(entry, data, zipfile.ZIP_DEFLATED)
        for name, text in files.items():
            wheel.writestr(name, text)
    fresh.replace(path)
    print(f"[viscache] licences inside: {', '.join(added)}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
