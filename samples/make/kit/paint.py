"""Paints a texture by position: every texel asks a function of the point of the surface that it covers."""
import bpy
import numpy as np


def unwrap(item, angle=66.0, margin=0.01):
    """Gives a mesh texture coordinates by Blender's smart projection."""
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(angle_limit=np.radians(angle), island_margin=margin)
    bpy.ops.object.mode_set(mode="OBJECT")
    item.select_set(False)


def positions(item, size):
    """(points, covered): the surface point of each texel, rows from the top; islands are grown over the gaps."""
    mesh = item.data
    mesh.calc_loop_triangles()
    uv = np.array([d.uv for d in mesh.uv_layers.active.data])
    co = np.array([v.co for v in mesh.vertices])
    points, covered = np.zeros((size, size, 3)), np.zeros((size, size), bool)
    for triangle in mesh.loop_triangles:
        t = uv[list(triangle.loops)] * size
        p = co[list(triangle.vertices)]
        low, high = np.floor(t.min(0)).astype(int), np.ceil(t.max(0)).astype(int)
        x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
        a, b = t[1] - t[0], t[2] - t[0]
        area = a[0] * b[1] - a[1] * b[0]
        if abs(area) < 1e-12:
            continue
        dx, dy = x - t[0][0], y - t[0][1]
        u, v = (dx * b[1] - dy * b[0]) / area, (a[0] * dy - a[1] * dx) / area
        inside = (u >= -0.02) & (v >= -0.02) & (u + v <= 1.02)
        ix, iy = np.clip(x[inside].astype(int), 0, size - 1), np.clip(y[inside].astype(int), 0, size - 1)
        w = np.stack([1 - u - v, u, v], -1)[inside]
        points[iy, ix], covered[iy, ix] = w @ p, True
    for _ in range(size // 64):
        grow(points, covered)
    return points[::-1], covered[::-1]


def grow(points, covered):
    """Copies each covered texel to its uncovered neighbours."""
    for shift in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near = np.roll(covered, shift, (0, 1)) & ~covered
        points[near] = np.roll(points, shift, (0, 1))[near]
        covered |= near


def paint(item, size, color):
    """An image (size, size, 3) of `color`(points (n, 3)) -> (n, 3)."""
    points, covered = positions(item, size)
    out = np.zeros((size, size, 3))
    out[covered] = color(points[covered])
    return out
