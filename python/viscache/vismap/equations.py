"""Equations of the visibility maps on arrays, and estimates of single points."""

from viscache._core import AlphaMode, PointSet
from viscache._core.sampling import EnvironmentMap, ShadingPoint, equal_area_to_direction, eval_bsdf
from viscache._core.vismap import (
    EnvironmentPyramid,
    PointEstimate,
    dilated,
    morton2,
    points,
    record_weight,
)

__all__ = [
    "AlphaMode",
    "EnvironmentMap",
    "EnvironmentPyramid",
    "PointEstimate",
    "PointSet",
    "ShadingPoint",
    "dilated",
    "equal_area_to_direction",
    "eval_bsdf",
    "morton2",
    "points",
    "record_weight",
]
