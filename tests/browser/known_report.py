"""A report whose pictures are known."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

WIDTH, HEIGHT = 64, 48


@dataclass(frozen=True)
class Report:
    """The file, its sweep, and each setting's picture and reference in linear radiance."""

    path: Path
    directory: Path
    pictures: dict[str, np.ndarray]
    reference: np.ndarray
