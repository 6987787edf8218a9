"""Labels of variables in axes, tables and reports: the papers' symbol or words, and the unit."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Mapping

#: Name → (words, unit). A symbol is between dollar signs: `$C_E$`, `$\\theta_{max}$`, `$\\hat L$`.
LABELS: dict[str, tuple[str, str]] = {
    # The quantized cache
    "c_e": ("$C_E$", "px"),
    "c_l": ("$C_L$", ""),
    "c_n": ("$C_N$", ""),
    "c_z": ("$C_Z$", ""),
    "c_r": ("$C_R$", ""),
    "c_msr": ("$C_{MSR}$", ""),
    "c_pg": ("$C_{PG}$", ""),
    "c_w": ("$C_W$", ""),
    # The visibility field
    "n_tiles": ("tiles $n$", ""),
    "n_directions": ("directions $l$", ""),
    "bsp_depth": ("most halvings of a tile", ""),
    # Visibility maps
    "m": ("$M$", ""),
    "d_max": ("$d_{max}$", "image widths"),
    "theta_max_deg": (r"$\theta_{max}$", "°"),
    "w_min": ("$w_{min}$", ""),
    "delta_max": (r"$\delta_{max}$", ""),
    "eps_max": (r"$\epsilon_{max}$", ""),
    "lam": (r"$\lambda$", ""),
    "n_best": ("records blended", ""),
    "m_nearest": ("nearest records $m$", ""),
    "n_startup": ("start-up records", ""),
    # Integrators
    "n_vpls": ("VPLs", ""),
    "n_samples": ("samples per eye point", ""),
    "n_environment": ("samples of the environment", ""),
    "n_area": ("samples of area lights", ""),
    "spp": ("samples per pixel", ""),
    # Errors
    "rel_l1": (r"rel_l1 ($\hat L_{INF}$)", ""),
    "rel_l1_reflected": ("rel_l1 of light on surfaces", ""),
    "rmse": ("RMSE", "radiance"),
    "rel_mse": ("relative MSE", ""),
    "nmse": ("MSE over squared mean", ""),
    "energy": ("energy error", ""),
    "flip": ("mean HDR-FLIP", ""),
    "ssim": ("SSIM", ""),
    "max_abs": ("largest error", "radiance"),
    # Costs
    "total_s": ("time per frame", "s"),
    "visibility_s": ("visibility time", "s"),
    "cpu_s": ("CPU time", "s"),
    "rays": ("shadow rays", ""),
    "queries": ("visibility queries", ""),
    "ray_reduction": ("queries per ray", ""),
    "speedup": ("speed-up over exact", "×"),
    "cpu_speedup": ("CPU speed-up over exact", "×"),
}

_GREEK = {"theta": "θ", "delta": "δ", "epsilon": "ε", "lambda": "λ"}
_SYMBOL = re.compile(r"\$(\\hat )?(\\?\w+?)(?:_(?:\{(\w+)\}|(\w)))?\$")

Symbol = Callable[[str, str, bool], str]


def mathtext(name: str, unit: bool = True) -> str:
    """For matplotlib: `$C_E$ [px]`."""

    def symbol(base: str, below: str, hat: bool) -> str:
        base = next((f"\\{word}" for word, letter in _GREEK.items() if letter == base), base)
        base = rf"\hat {base}" if hat else base
        index = below if len(below) == 1 else rf"{{\mathrm{{{below}}}}}"
        return f"${base}_{index}$" if below else f"${base}$"

    return _written(name, unit, symbol)


def plain(name: str, unit: bool = True) -> str:
    """Without markup: `C_E [px]`."""
    return _written(
        name,
        unit,
        lambda base, below, hat: base + ("\u0302" if hat else "") + (f"_{below}" if below else ""),
    )


def as_html(name: str, unit: bool = True) -> str:
    """Escaped, with italics and indices: `<i>C</i><sub>E</sub> [px]`."""
    return _written(
        name,
        unit,
        lambda base, below, hat: (
            f"<i>{base}{_hat(hat)}</i>" + (f"<sub>{below}</sub>" if below else "")
        ),
        html.escape,
    )


def as_svg(name: str, unit: bool = True) -> str:
    """The content of an SVG `<text>`, escaped."""

    def symbol(base: str, below: str, hat: bool) -> str:
        text = f'<tspan font-style="italic">{base}{_hat(hat)}</tspan>'
        lower = '<tspan font-size=".75em" dy=".3em">{}</tspan><tspan dy="-.22em">\u200b</tspan>'
        return text + (lower.format(below) if below else "")

    return _written(name, unit, symbol, html.escape)


def level(value: object) -> str:
    """A parameter's value with five significant digits, for a point's name."""
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def setting(values: Mapping[str, object]) -> str:
    """A setting without markup: `C_E = 8, C_N = 4`."""
    return ", ".join(f"{plain(k, unit=False)} = {level(v)}" for k, v in values.items())


def number(value: float) -> str:
    """A number as on an axis: 0.02, 1500, 2M."""
    for limit, suffix in ((1e9, "G"), (1e6, "M"), (1e4, "k")):
        if abs(value) >= limit:
            scale = 1e3 if suffix == "k" else limit
            return f"{value / scale:.4g}{suffix}"
    return f"{value:.4g}"


def _hat(hat: bool) -> str:
    return "\u0302" if hat else ""


def _written(
    name: str, unit: bool, symbol: Symbol, escape: Callable[[str], str] = lambda text: text
) -> str:
    words, its_unit = _words(name)
    parts, at = [], 0
    for found in _SYMBOL.finditer(words):
        base = found[2]
        base = _GREEK[base[1:]] if base.startswith("\\") else base
        parts += [
            escape(words[at : found.start()]),
            symbol(base, found[3] or found[4] or "", bool(found[1])),
        ]
        at = found.end()
    parts.append(escape(words[at:]))
    return "".join(parts) + (f" [{escape(its_unit)}]" if unit and its_unit else "")


def _words(name: str) -> tuple[str, str]:
    """Words and unit; for `integrator.n_vpls` only the last part counts."""
    if name in LABELS:
        return LABELS[name]
    for prefix, before in (("converged_", "total"), ("exact_", "exact frame's")):
        if name.startswith(prefix):
            words, unit = _words(name.removeprefix(prefix))
            return f"{before} {words}", unit
    short = name.rpartition(".")[2]
    return LABELS.get(short, (short.replace("_", " "), ""))
