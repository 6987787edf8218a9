"""Colours of the furnished scenes: plausible albedos from 4 to 86 %."""

from __future__ import annotations

Rgb = tuple[float, float, float]

COLORS: dict[str, Rgb] = {
    "plaster": (0.78, 0.76, 0.71),
    "sage": (0.52, 0.58, 0.47),
    "blue_wall": (0.44, 0.53, 0.60),
    "rose_wall": (0.70, 0.55, 0.50),
    "ceiling": (0.84, 0.83, 0.80),
    "floor_oak": (0.46, 0.32, 0.20),
    "floor_tile": (0.58, 0.56, 0.52),
    "white_paint": (0.82, 0.81, 0.78),
    "oak": (0.50, 0.33, 0.18),
    "walnut": (0.27, 0.16, 0.09),
    "beech": (0.66, 0.48, 0.30),
    "black_metal": (0.05, 0.05, 0.055),
    "steel": (0.45, 0.46, 0.47),
    "brass": (0.60, 0.46, 0.20),
    "linen": (0.72, 0.66, 0.55),
    "petrol": (0.10, 0.29, 0.33),
    "grey_cloth": (0.36, 0.37, 0.39),
    "mustard": (0.72, 0.48, 0.10),
    "terracotta": (0.62, 0.29, 0.17),
    "brick_red": (0.52, 0.14, 0.10),
    "navy": (0.09, 0.13, 0.28),
    "forest": (0.10, 0.24, 0.12),
    "cream": (0.80, 0.73, 0.58),
    "plum": (0.32, 0.12, 0.24),
    "sky": (0.38, 0.58, 0.72),
    "leaf": (0.16, 0.36, 0.10),
    "leaf_light": (0.30, 0.48, 0.14),
    "bark": (0.25, 0.17, 0.11),
    "soil": (0.11, 0.08, 0.06),
    "orange": (0.80, 0.37, 0.06),
    "apple": (0.60, 0.10, 0.07),
    "lemon": (0.80, 0.68, 0.12),
    "porcelain": (0.83, 0.83, 0.81),
    "shade": (0.86, 0.80, 0.68),
    "paper": (0.82, 0.80, 0.74),
    "screen": (0.04, 0.045, 0.05),
    "stone": (0.55, 0.52, 0.46),
    "limestone": (0.70, 0.64, 0.53),
    "water": (0.14, 0.28, 0.31),
    "rug_red": (0.45, 0.14, 0.12),
    "rug_beige": (0.64, 0.57, 0.46),
}

BOOK_COLORS = ("brick_red", "navy", "forest", "cream", "mustard", "plum", "petrol", "paper")
