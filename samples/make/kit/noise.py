"""Smooth value noise in space, seeded, for painting and denting."""
import numpy as np


def lattice(i, seed):
    """A pseudo-random number in [0, 1) for each integer point of (n, 3)."""
    h = (i[:, 0] * 374761393 + i[:, 1] * 668265263 + i[:, 2] * 2147483647 + seed * 1274126177).astype(np.uint64) & 0xFFFFFFFF
    h = ((h ^ (h >> np.uint64(13))) * np.uint64(1274126177)) & np.uint64(0xFFFFFFFF)
    h = ((h ^ (h >> np.uint64(16))) * np.uint64(2654435761)) & np.uint64(0xFFFFFFFF)
    return (h ^ (h >> np.uint64(15))).astype(float) / 2**32


def smooth(p, seed=0):
    """Quintic-interpolated value noise in [0, 1] at points (n, 3); features have size 1."""
    cell = np.floor(p).astype(np.int64)
    f = p - cell
    w = f**3 * (f * (6 * f - 15) + 10)
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, w, 1 - w), axis=1)
        total = total + weight * lattice(cell + np.array(corner), seed)
    return total


def fractal(p, octaves=4, seed=0):
    """A sum of octaves, in [0, 1]."""
    total, scale = 0.0, 0.0
    for i in range(octaves):
        total, scale = total + 0.5**i * smooth(p * 2**i, seed + i), scale + 0.5**i
    return total / scale
