"""A rendered frame: layers, counters, timings, parameters, provenance, all in one EXR file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.base import tonemap
from viscache.base.array_digests import changed_layers, layer_digests, pixels_digest
from viscache.base.array_output import ArrayOutput
from viscache.base.files import about_exr, whole_file
from viscache.base.formats import (
    DIGESTS,
    TABLE,
    TEXTS,
    Field,
    Format,
    FormatError,
    is_text,
    list_of,
)
from viscache.base.formats import table_of as _table_of
from viscache.base.provenance import provenance as _provenance
from viscache.base.real_numbers import real_array
from viscache.frame.audit_result import PixelErrors, QueryErrors, result
from viscache.frame.html import frame_html
from viscache.settings.checks import require
from viscache.settings.parameter_rows import fill
from viscache.settings.spelling import spelled

Layer = npt.NDArray[np.float32]

#: Kind of file by suffix: what `Frame.save` writes.
KINDS: dict[str, Literal["exr", "png", "jpeg"]] = {
    ".exr": "exr",
    ".png": "png",
    ".jpg": "jpeg",
    ".jpeg": "jpeg",
}
_RECORDS = ("counters", "timings", "parameters", "provenance")
#: Name of the header attribute with the head, in which all records are.
ATTRIBUTE = "viscache.frame"
#: Version 1 had an attribute for each record.
FORMAT = Format(
    kind="a frame of Frame.save",
    version=2,
    fields={
        "layers": Field("a table of lists of channels", _table_of(list_of(is_text))),
        "sha256": DIGESTS,
        "warnings": TEXTS,
        **dict.fromkeys(_RECORDS, TABLE),
    },
)
#: What OpenEXR, NumPy and the records raise for files that are cut off or changed.
_UNREADABLE = (RuntimeError, ValueError, TypeError, LookupError, AttributeError)


@spelled
@dataclass(eq=False, kw_only=True, slots=True)
class Frame(ArrayOutput):
    """What `viscache.render` returns.

    `np.asarray(frame)` and `torch.from_dlpack(frame)` are its image.

    Parameters
    ----------
    layers : dict of str to (H, W, C) float32
        Scene-linear; the colour layer is named "color" and comes first. (H, W) becomes (H, W, 1).
    counters : dict
        Plain Python numbers; nested dicts per light group, lists per level. "queries", "occluded"
        and "rays" are sums over light groups, "ray_reduction" is queries per ray, and "vpls" counts
        virtual point lights. Those of tables of the whole frame, kept tables, corrections and
        product samples are there where a frame has such.

        {counters}
    timings : dict of str to float
        Seconds. Names that end in "cpu_s" are CPU seconds, summed over threads. All others are wall
        seconds: "total_s", "build_s" (the ray caster), "lights_s", "tiles_s", ... "visibility_s"
        and "shading_s" are CPU seconds divided by the number of threads.
    parameters : dict
        Settings of the frame, JSON-able.
    provenance : dict
        Versions, ISA variant, threads, date (`viscache.base.provenance.provenance`).
    warnings : list of str
        Features of the scene that are not supported, and problems during rendering.

    Raises
    ------
    ValueError
        No "color" layer, layers of different sizes, or a record that JSON cannot hold.
    """

    layers: dict[str, Layer]
    counters: dict[str, Any] = field(default_factory=dict)
    timings: dict[str, float] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=_provenance)
    warnings: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        if "color" not in self.layers:
            raise ValueError(f'layers must have "color", got {sorted(self.layers)}')
        ordered = {"color": self.layers["color"], **self.layers}
        self.layers = {name: _as_layer(name, pixels) for name, pixels in ordered.items()}
        sizes = {name: pixels.shape[:2] for name, pixels in self.layers.items()}
        if len(set(sizes.values())) > 1:
            raise ValueError(f"layers must all have one size, got {sizes}")
        for name in _RECORDS:
            setattr(self, name, _plain(getattr(self, name), name))

    @property
    def image(self) -> Layer:
        """The colour layer, (H, W, C) float32, scene-linear."""
        return self.layers["color"]

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        height, width = self.image.shape[:2]
        return (width, height)

    @property
    def sha256(self) -> str:
        """Hex digest of the little-endian float32 pixels of the colour layer."""
        return pixels_digest(self.image)

    @property
    def audit(self) -> PixelErrors | QueryErrors | None:
        """Estimates of the error, from queries that exact rays answered as well.

        With `audit=` of `viscache.render`: with 95 % intervals. Other frames of the quantized cache
        audit 256 pixels or fewer: without intervals. None if nothing was audited.
        """
        return result(self.counters.get("audit"))

    def save(self, path: str | os.PathLike[str], *, exposure: float | None = None) -> None:
        """Write a file; its suffix determines the format. The file is complete or absent.

        `.exr`: all layers, scene-linear; tev shows them, `load` reads them back. The header has the
        records as JSON, and the SHA-256 of each layer. The colour layer is R, G, B at top level.
        Other layers are `name.R/G/B`, `name.X/Y/Z` (position, normal), `name.V` (one channel) or
        `name.0, name.1, ...`. `.png`, `.jpg`, `.jpeg`: the colour layer with 8 bits and the sRGB
        curve.

        Parameters
        ----------
        path : path
        exposure : float, optional
            Factor before the curve of a PNG or JPEG; `viscache.base.tonemap.display_exposure` by
            default.

        Raises
        ------
        ValueError
            Another suffix, or an exposure for an EXR.
        OSError
            The file cannot be written.
        """
        self._save(Path(path), exposure)

    def _save(
        self,
        target: Path,
        exposure: float | None = None,
        within: AbstractContextManager[object] | None = None,
    ) -> None:
        """Write a file, which takes its place within a context (`base.files.whole_file`)."""
        kind = checked_suffix(target)
        linear = kind == "exr"
        require(not linear or exposure is None, "exposure must be left out for .exr", exposure)
        try:
            with whole_file(target, within) as partial:
                if linear:
                    self._write_exr(partial)
                else:
                    pixels = tonemap.to_srgb8(self.image, exposure)
                    partial.write_bytes(tonemap.encode(pixels, kind=kind))
        except (RuntimeError, OSError) as error:
            raise OSError(f"cannot write {target}: {error}") from error

    def _write_exr(self, target: Path) -> None:
        import OpenEXR

        channels: dict[str, Any] = {}
        index: dict[str, list[str]] = {}
        for name, pixels in self.layers.items():
            index[name] = _channel_names(name, pixels.shape[2])
            for i, channel in enumerate(index[name]):
                channels[channel] = np.ascontiguousarray(pixels[:, :, i])
        fields = {
            "layers": index,
            "sha256": layer_digests(self.layers),
            "warnings": self.warnings,
            **{name: getattr(self, name) for name in _RECORDS},
        }
        header: dict[str, Any] = {
            "compression": OpenEXR.ZIP_COMPRESSION,
            "type": OpenEXR.scanlineimage,
            ATTRIBUTE: FORMAT.sealed(fields),
        }
        OpenEXR.File(header, channels).write(str(target))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Frame:
        """Read an EXR: one that `save` wrote, or any other with R, G, B (or Y) at top level.

        A frame of viscache must be as it was saved. Pictures of other programs have no hashes and
        are not checked.

        Raises
        ------
        FileNotFoundError
            There is no such file.
        ValueError
            Not an EXR file, one without a colour layer, or a frame of another version or that is
            not as it was saved; the message names the file and the layers.
        """
        source = Path(path)
        if not source.is_file():
            raise FileNotFoundError(f"no such file: {source}")
        with source.open("rb") as start:
            if start.read(4) != b"v/1\x01":
                raise FormatError(f"{source} is not an OpenEXR file")
        try:
            return cls._read_exr(source)
        except FormatError:
            raise
        except _UNREADABLE as error:
            text = about_exr(error)
            told = text if str(source) in text else f"{source} cannot be read: {text}"
            raise FormatError(told) from error

    @classmethod
    def _read_exr(cls, source: Path) -> Frame:
        import OpenEXR

        with OpenEXR.File(str(source), separate_channels=True) as file:
            header = dict(file.header())
            planes = {n: np.asarray(c.pixels) for n, c in file.channels().items()}
        head = _head(header)
        if head is None:
            return cls(layers=_layers(planes, _foreign_layers(planes, source), source))
        fields = FORMAT.opened(source, head)
        others = sorted(name for name, plane in planes.items() if plane.dtype != np.float32)
        if others:
            raise FORMAT.refusal(source, f"channels must be float32, got others in {others}")
        layers = _layers(planes, fields.pop("layers"), source)
        changed = changed_layers(layer_digests(layers), fields.pop("sha256"))
        if changed:
            raise FormatError(
                f"{source} is not as it was saved: the hash does not fit for the layers"
                f" {', '.join(changed)} (a program that changes pixels must drop the header"
                f" attribute {ATTRIBUTE})"
            )
        return cls(layers=layers, **fields)

    def summary(self) -> dict[str, Any]:
        """What `viscache render --json` prints."""
        return {
            "counters": self.counters,
            "timings": self.timings,
            "parameters": self.parameters,
            "sha256": self.sha256,
            "warnings": list(self.warnings),
        }

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Frame {width}x{height} layers={list(self.layers)} sha256={self.sha256[:12]}>"

    def _repr_html_(self) -> str:
        return frame_html(self.image, self.timings, self.counters)

    def _array(self) -> Layer:
        return self.image


fill(Frame, "counters", [(f'"{name}"', doc) for name, doc in _core.counter_rows().items()])


def count_broken_pixels(frame: Frame) -> None:
    """Count pixels whose colour is not finite, in counters and as a warning."""
    broken = int((~np.isfinite(frame.image).all(axis=2)).sum())
    frame.counters["non_finite_pixels"] = broken
    frame.counters["non_finite"] = frame.counters.get("non_finite", 0) + broken
    if broken:
        frame.warnings.append(
            f"{broken} pixels are not finite: sums of light overflowed. Scale the lights down"
        )


def checked_suffix(path: Path) -> Literal["exr", "png", "jpeg"]:
    """The kind of file by suffix; ValueError if `Frame.save` does not write that kind."""
    suffix = path.suffix.lower()
    require(suffix in KINDS, f"path must end in {', '.join(KINDS)}", str(path))
    return KINDS[suffix]


def _as_layer(name: str, pixels: npt.ArrayLike) -> Layer:
    layer = real_array(pixels, f"layer {name}")
    if layer.ndim == 2:
        layer = layer[:, :, None]
    if layer.ndim != 3 or 0 in layer.shape:
        raise ValueError(
            f"layer {name} must have shape (H, W, C), none of them 0, got {layer.shape}"
        )
    fits = isinstance(name, str) and name.isprintable() and 0 < len(name.encode()) <= 240
    if not fits or "." in name:
        raise ValueError(
            "a layer's name must be printable text without a dot, of at most 240 bytes and not"
            f" empty, got {name!r}"
        )
    return np.ascontiguousarray(layer, dtype=np.float32)


def _plain(value: Any, where: str) -> Any:
    """The value with plain Python numbers and lists; ValueError if JSON cannot hold it."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(k): _plain(v, f"{where}.{k}") for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v, f"{where}[{i}]") for i, v in enumerate(value)]
    raise ValueError(f"{where} must be JSON-able, got {type(value).__name__}")


def _channel_names(layer: str, count: int) -> list[str]:
    if layer == "color":
        top = {1: ["Y"], 3: ["R", "G", "B"], 4: ["R", "G", "B", "A"]}
        return top.get(count, [f"color.{i}" for i in range(count)])
    vector = layer in ("position", "normal", "shading_normal", "direction")
    three = ["X", "Y", "Z"] if vector else ["R", "G", "B"]
    parts = {1: ["V"], 2: ["X", "Y"], 3: three, 4: ["R", "G", "B", "A"]}
    return [f"{layer}.{p}" for p in parts.get(count, [str(i) for i in range(count)])]


def _foreign_layers(planes: Mapping[str, Any], source: Path) -> dict[str, list[str]]:
    """Channels of a file that another program wrote, grouped by the name before the last dot."""
    groups: dict[str, list[str]] = {}
    for channel in sorted(planes, key=lambda c: ("RGBAXYZ".find(c.rpartition(".")[2]), c)):
        groups.setdefault(channel.rpartition(".")[0].replace(".", "_"), []).append(channel)
    top = groups.pop("", [])
    layers: dict[str, list[str]]
    if {"R", "G", "B"} <= set(top):
        layers = {"color": ["R", "G", "B"]}
    elif "Y" in top:
        layers = {"color": ["Y"]}
    elif "color" in groups:
        layers = {"color": groups.pop("color")}
    else:
        raise ValueError(f"{source} has no R, G, B (or Y) channels, got {sorted(planes)}")
    if "A" in top:
        layers["alpha"] = ["A"]
    return {**groups, **layers}


def _head(header: Mapping[str, Any]) -> str | None:
    """The head of a frame of viscache, also where the name of its attribute is damaged."""
    for name, value in header.items():
        if name.startswith("viscache") or (isinstance(value, str) and FORMAT.kind in value):
            return str(value)
    return None


def _layers(
    planes: Mapping[str, Any], index: Mapping[str, list[str]], source: Path
) -> dict[str, Layer]:
    missing = [c for names in index.values() for c in names if c not in planes]
    if missing or not all(index.values()):
        raise ValueError(f"{source} lacks the channels {missing} that its header names")
    return {
        name: np.stack([np.asarray(planes[c], np.float32) for c in names], 2)
        for name, names in index.items()
    }
