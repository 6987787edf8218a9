"""Built-in scenes that many tests use."""

from functools import cache

import viscache as vc


@cache
def built(spec: str) -> vc.Scene:
    """A built-in scene, made once for all tests of a process, which leave it as it is."""
    return vc.scenes.build(spec)
