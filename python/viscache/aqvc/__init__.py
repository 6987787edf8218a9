"""The equations of the quantized cache on arrays (Popov, Georgiev, Slusallek, Dachsbacher 2013)."""

from viscache.aqvc.equations import eye_keys, hash_keys, resolution_eye

__all__ = ["eye_keys", "hash_keys", "resolution_eye"]
