"""The families of checks, which declare themselves by `@FAMILIES.add`."""

from viscache_lab.experiment.registry import FAMILIES

FAMILIES.load()
