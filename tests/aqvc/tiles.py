"""A small analytic scene: its eye points seen through a pinhole, and lights of every kind."""

import numpy as np

from core import testing
from viscache import _core

BOXES = np.array(
    [
        [-5, -0.2, -5, 5, 0, 5],
        [-5, 0, -5.2, 5, 4, -5],
        [-3, 0, -2, -2, 1.5, -1],
        [1, 0, -3.5, 2.2, 2.2, -2.5],
        *[[-1.5 + 0.3 * i, 1.2, -0.5, -1.4 + 0.3 * i, 1.3, 1.5] for i in range(8)],
    ],
    np.float32,
)
SPHERES = np.array([[0, 0.7, -1.5, 0.7], [-3.2, 0.5, 1.5, 0.5]], np.float32)
CENTER, RADIUS, EXTENT = (0.0, 1.9, -0.1), 7.5, 15.0
POINT, DIRECTION, SURFACE, SOLID_ANGLE = range(4)
GROUPS = {"point": 0, "directional": 1, "area": 2, "environment": 3, "vpl": 4, "ambient": 5}


def caster():
    """The scene as a ray caster."""
    return testing.AnalyticCaster(BOXES, SPHERES)


def first_hits(origin, direction):
    """Distance and outward normal of the first hit of every ray."""
    n = len(direction)
    best, normal = np.full(n, np.inf), np.zeros((n, 3))
    with np.errstate(divide="ignore", invalid="ignore"):
        for box in BOXES.astype(np.float64):
            t0, t1 = (box[:3] - origin) / direction, (box[3:] - origin) / direction
            near, far = np.minimum(t0, t1), np.maximum(t0, t1)
            axis, enter, leave = near.argmax(1), near.max(1), far.min(1)
            hit = (enter <= leave) & (enter > 1e-6) & (enter < best)
            best[hit] = enter[hit]
            face = np.zeros((n, 3))
            face[np.arange(n), axis] = -np.sign(direction[np.arange(n), axis])
            normal[hit] = face[hit]
        for x, y, z, r in SPHERES.astype(np.float64):
            q = origin - np.array([x, y, z])
            b, c = direction @ q, q @ q - r * r
            t = -b - np.sqrt(b * b - c)
            hit = (t > 1e-6) & (t < best)
            best[hit] = t[hit]
            normal[hit] = (q + t[hit, None] * direction[hit]) / r
    return best, normal


def spread_bits(v):
    """Moves bit b to bit 2b."""
    v = np.asarray(v, np.uint64)
    out = np.zeros_like(v)
    for b in range(16):
        out |= ((v >> np.uint64(b)) & np.uint64(1)) << np.uint64(2 * b)
    return out


def eye_points(width: int = 32, height: int = 32) -> dict:
    """Eye points of a width × height image in Morton order, as TileRun takes them."""
    eye, half = np.array([0.3, 3.0, 7.5]), np.tan(np.radians(30))
    y, x = np.divmod(np.arange(width * height), width)
    forward = np.array([-0.3, -2.4, -8.0])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    u, v = (2 * (x + 0.5) / width - 1) * half, (1 - 2 * (y + 0.5) / height) * half
    d = forward + u[:, None] * right + v[:, None] * up
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    t, n = first_hits(eye, d)
    ok = np.isfinite(t)
    cos_x = np.maximum(-(n * d).sum(1), 0.05)
    pixel = (2 * half / width) * (2 * half / height)
    density = cos_x / (pixel * (d @ forward) ** 3 * np.where(ok, t, 1.0) ** 2)
    order = np.argsort(spread_bits(x) | spread_bits(y) << np.uint64(1), kind="stable")
    order = order[ok[order]]
    position = (eye + d * np.where(ok, t, 1.0)[:, None])[order]
    return {
        "position": position.astype(np.float32),
        "normal": n[order].astype(np.float32),
        "density": density[order].astype(np.float32),
        "order_x": x[order].tolist(),
        "order_y": y[order].tolist(),
        "tile_width": width,
        "tile_height": height,
    }


def lights(kind: str, count: int = 8, seed: int = 1) -> dict:
    """Lights of one group as TileRun takes them."""
    rng = np.random.default_rng(seed)
    normal, density = np.zeros((count, 3)), np.zeros(count)
    if kind in ("directional", "environment", "ambient"):
        far = rng.normal(size=(count, 3))
        far[:, 1] = np.abs(far[:, 1]) + 0.2
        far /= np.linalg.norm(far, axis=1, keepdims=True)
        density += count / (2 * np.pi)
    else:
        far = rng.uniform([-4, 2.5, -4], [4, 6, 4], (count, 3))
        if kind in ("vpl", "area"):
            normal[:, 1] = -1
            density += count / 64
    semantic = {"directional": 1, "ambient": 1, "environment": 3, "vpl": 2, "area": 2}
    return {
        "semantic": semantic.get(kind, 0),
        "group": GROUPS[kind],
        "far": far.astype(np.float32),
        "normal": normal.astype(np.float32),
        "density": density.astype(np.float32),
    }


def facing(eyes: dict, far_ends: dict) -> np.ndarray:
    """Pairs with a non-zero unoccluded contribution."""
    e, n = eyes["position"].astype(np.float64), eyes["normal"].astype(np.float64)
    y = far_ends["far"].astype(np.float64)
    if far_ends["semantic"] in (DIRECTION, SOLID_ANGLE):
        return n @ y.T > 0
    d = y[None] - e[:, None]
    lit = (d * n[:, None]).sum(-1) > 0
    if far_ends["semantic"] == SURFACE:
        lit &= (d * far_ends["normal"][None]).sum(-1) < 0
    return lit


def tile_run(eyes: dict, **options):
    """A cache over the eye points with the given parameters; every light group is cached."""
    parameters = _core.aqvc.AqvcParameters(**{"exact_groups": ()} | options)
    return testing.TileRun(
        caster(), eyes, parameters, center=CENTER, radius=RADIUS, extent=EXTENT, spp=1
    )
