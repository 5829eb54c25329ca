"""Meshes, all in metres, Z up (the exporter turns them to glTF's Y up). Closed ones have outward normals."""
import math

import bmesh
import bpy
import numpy as np


def link(mesh, name, material=None, smooth=True):
    """A new object of a mesh in the scene."""
    for polygon in mesh.polygons:
        polygon.use_smooth = smooth
    if material is not None:
        mesh.materials.append(material)
    item = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(item)
    return item


def from_arrays(name, vertices, faces, material=None, smooth=True):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(map(int, f)) for f in faces])
    mesh.validate()
    return link(mesh, name, material, smooth)


def grid_faces(rows, columns, closed_rows, closed_columns, offset=0):
    """Quads of a grid of vertices row * columns + column, optionally wrapped around."""
    faces = []
    for r in range(rows if closed_rows else rows - 1):
        for c in range(columns if closed_columns else columns - 1):
            r1, c1 = (r + 1) % rows, (c + 1) % columns
            faces.append([offset + i for i in (r * columns + c, r * columns + c1, r1 * columns + c1, r1 * columns + c)])
    return faces


def lathe(name, profile, material=None, segments=96, smooth=True):
    """A solid of revolution about Z. `profile` is a list of (radius, height) from the lower to the upper point on the
    axis, running up along the outside; both ends have radius 0."""
    inner = profile[1:-1]
    angles = [2 * math.pi * i / segments for i in range(segments)]
    vertices = [(r * math.cos(a), r * math.sin(a), z) for r, z in inner for a in angles]
    faces = grid_faces(len(inner), segments, False, True)
    bottom, top = len(vertices), len(vertices) + 1
    vertices += [(0, 0, profile[0][1]), (0, 0, profile[-1][1])]
    last = (len(inner) - 1) * segments
    for i in range(segments):
        j = (i + 1) % segments
        faces.append((bottom, j, i))
        faces.append((top, last + i, last + j))
    return from_arrays(name, vertices, faces, material, smooth)


def rounded(points, radius, steps=6):
    """A polyline (radius, height) whose inner corners are replaced by arcs of at most `radius`; a corner given as
    (r, z, radius) has its own."""
    out = [points[0][:2]]
    for before, corner, after in zip(points, points[1:], points[2:]):
        limit = corner[2] if len(corner) > 2 else radius
        p, a, b = (np.array(q[:2], float) for q in (corner, before, after))
        to_a, to_b = a - p, b - p
        la, lb = np.linalg.norm(to_a), np.linalg.norm(to_b)
        to_a, to_b = to_a / la, to_b / lb
        half = math.acos(np.clip(to_a @ to_b, -1, 1)) / 2
        if limit <= 0 or half > 1.55:
            out.append(tuple(p))
            continue
        reach = min(limit / math.tan(half), 0.49 * la, 0.49 * lb)
        arc = reach * math.tan(half)
        centre = p + (to_a + to_b) / np.linalg.norm(to_a + to_b) * arc / math.sin(half)
        start, end = p + to_a * reach - centre, p + to_b * reach - centre
        sweep = math.acos(np.clip(start @ end / arc**2, -1, 1))
        sign = math.copysign(1, start[0] * end[1] - start[1] * end[0])
        for i in range(steps + 1):
            t = sign * sweep * i / steps
            c, s = math.cos(t), math.sin(t)
            out.append((centre[0] + c * start[0] - s * start[1], centre[1] + s * start[0] + c * start[1]))
    return out + [points[-1][:2]]


def tube(name, curve, radius, material=None, sides=32):
    """A closed tube along a closed curve: `curve` is (n, 3); the frame is transported and its twist closed."""
    curve = np.asarray(curve, float)
    count = len(curve)
    tangent = np.roll(curve, -1, 0) - np.roll(curve, 1, 0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.cross(tangent[0], (0.3, 0.5, 0.8))
    frames = []
    for i in range(count + 1):
        t = tangent[i % count]
        side = side - t * (side @ t)
        side /= np.linalg.norm(side)
        frames.append(side)
    t0, closing = tangent[0], frames[count]
    twist = math.atan2(np.cross(closing, frames[0]) @ t0, closing @ frames[0])
    radius = np.broadcast_to(radius, count)
    vertices = []
    for i in range(count):
        u, w = frames[i], np.cross(tangent[i], frames[i])
        for k in range(sides):
            a = 2 * math.pi * k / sides + twist * i / count
            vertices.append(curve[i] + radius[i] * (math.cos(a) * u + math.sin(a) * w))
    return from_arrays(name, vertices, grid_faces(count, sides, True, True), material)


def ellipsoid(name, centre, half_axes, material=None, subdivisions=4, rotation=(0, 0, 0)):
    mesh = bpy.data.meshes.new(name)
    b = bmesh.new()
    bmesh.ops.create_icosphere(b, subdivisions=subdivisions, radius=1)
    b.to_mesh(mesh)
    b.free()
    item = link(mesh, name, material)
    item.location, item.scale, item.rotation_euler = centre, half_axes, rotation
    return apply(item)


def box(name, centre, size, material=None, bevel=0.0, segments=4, rotation=(0, 0, 0)):
    """A box, its edges rounded by `bevel`."""
    mesh = bpy.data.meshes.new(name)
    b = bmesh.new()
    bmesh.ops.create_cube(b, size=1)
    bmesh.ops.scale(b, vec=size, verts=b.verts)
    if bevel > 0:
        bmesh.ops.bevel(b, geom=b.edges[:] + b.verts[:], offset=bevel, segments=segments, profile=0.5, affect="EDGES")
    b.to_mesh(mesh)
    b.free()
    item = link(mesh, name, material, smooth=bevel > 0)
    item.location, item.rotation_euler = centre, rotation
    return apply(item)


def load(name, path, height, material=None, yaw=0.0, up="y"):
    """A mesh file scaled to a height in metres, standing on z = 0, centred, turned by `yaw` degrees about Z."""
    vertices, faces = [], []
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("v "):
                vertices.append([float(v) for v in line.split()[1:4]])
            elif line.startswith("f "):
                faces.append([int(v.split("/")[0]) - 1 for v in line.split()[1:]])
    v = np.array(vertices)
    if up == "y":
        v = np.stack([v[:, 0], -v[:, 2], v[:, 1]], 1)
    v *= height / np.ptp(v[:, 2])
    v -= ((v.min(0) + v.max(0)) / 2 * (1, 1, 0)) + (0, 0, v[:, 2].min())
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
    v = v @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return from_arrays(name, v, faces, material)


def apply(item):
    """Bakes the object's own transform into its vertices."""
    bpy.context.view_layer.update()
    item.data.transform(item.matrix_basis)
    item.matrix_basis.identity()
    return item


def modify(item, kind, **settings):
    """Adds a modifier and applies it."""
    modifier = item.modifiers.new(kind, kind)
    for key, value in settings.items():
        setattr(modifier, key, value)
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(item.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph)
    item.modifiers.clear()
    old, item.data = item.data, mesh
    bpy.data.meshes.remove(old)
    return item


def smooth_shade(item, smooth=True):
    for polygon in item.data.polygons:
        polygon.use_smooth = smooth
    return item


def decimate(item, triangles):
    """Reduces a mesh to about so many triangles."""
    count = sum(len(p.vertices) - 2 for p in item.data.polygons)
    if count > triangles:
        modify(item, "DECIMATE", ratio=triangles / count)
    return smooth_shade(item)


def weld(item, distance):
    """Merges vertices closer than a distance, drops faces without area and triangulates: what a boolean leaves behind."""
    b = bmesh.new()
    b.from_mesh(item.data)
    bmesh.ops.remove_doubles(b, verts=b.verts, dist=distance)
    bmesh.ops.dissolve_degenerate(b, edges=b.edges, dist=distance)
    bmesh.ops.triangulate(b, faces=b.faces)
    b.to_mesh(item.data)
    b.free()
    return item


def join(name, items):
    """One object of several; the components stay apart."""
    with bpy.context.temp_override(active_object=items[0], object=items[0], selected_objects=items, selected_editable_objects=items):
        bpy.ops.object.join()
    items[0].name = items[0].data.name = name
    return items[0]
