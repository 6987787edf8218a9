"""The families of checks, a file each, which declare themselves by `@FAMILIES.add`."""

from viscache_lab.experiment.registry import FAMILIES

FAMILIES.load()
