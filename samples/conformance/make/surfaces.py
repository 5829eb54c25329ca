"""Surfaces as files have them: interpolated normals on clear bodies, and sheets that lie in one plane."""
import numpy as np

import truth
from case import Case
from document import icosphere, medium, plate, split_vertices, surface
from slabs import DOWN, unscaled
from touching import FURNACE, tumbler


def smooth():
    """Clear bodies whose normals are interpolated: where a ray leaves is decided by the triangles, how it refracts by the normals."""
    text = ("{what} with interpolated normals, clear and of index 1.5, in a uniform environment of radiance 1. Refraction by normals that differ from "
            "those of the triangles must neither lose nor make light, and no path may stay inside for ever: it cannot be seen. Near the silhouette, "
            "where the normals differ most, total reflection by interpolated normals can trap light: a renderer that cuts such paths off after a "
            "thousand bounces shows about 0.9975 over the whole picture. The middle is measured by itself.")
    n, radius, height = 1.5, 0.02, 0.08

    def case_of(name, title, what, mirrored, mesh, normals):
        case = Case(name, title, ["shading normals", "energy", "Fresnel"], text.format(what=what), spp=256).under(1)
        case.document.add(mesh, medium(ior=n), "body", normals=normals)
        why = "a furnace is exact; the margin is for single precision."
        expect = case.expect("the middle", [1, 1, 1], FURNACE, 0.001, why, [6, 6, 4, 4])
        unscaled(expect, mirrored, n)
        expect.symptom([mirrored] * 3, "light that went in is lost: paths are trapped and cut off")
        case.expect("whole picture", [1, 1, 1], FURNACE, 0.001, why)
        return case

    mesh, half = icosphere(radius, 1), 0.021
    case = case_of("smooth-sphere", "Clear sphere with smooth normals", "A sphere of 80 triangles", float(truth.square_of_ball(radius, half / 4, n)),
                   mesh, mesh[0] / radius)
    case.document.camera((-0.4, -0.3, -0.9), half, distance=0.2)
    yield case
    mesh, normals = smooth_walls(tumbler(8, height)[0])
    # The ray in the middle of the picture meets the wall in a plane that the axis lies in.
    direction = np.array([0.3, -0.4, -0.9])
    cos = np.hypot(direction[0], direction[2]) / np.linalg.norm(direction)
    case = case_of("smooth-tumbler", "Clear tumbler with smooth normals", "A tumbler of eight sides, round by its normals and flat at its ends,",
                   float(truth.fresnel(cos, n)), mesh, normals)
    case.document.camera(direction, 0.034, distance=0.5)
    yield case


def smooth_walls(mesh):
    """A body about y with the normals of round walls and of flat ends; each triangle has vertices of its own. And the normals."""
    points, triangles = mesh
    corners = points[triangles].astype(float)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    across /= np.linalg.norm(across, axis=1)[:, None]
    from_axis = corners * np.array([1, 0, 1])
    from_axis /= np.maximum(np.linalg.norm(from_axis, axis=2), 1e-9)[..., None]
    facing = np.sign(np.einsum("ij,ij->i", from_axis.mean(axis=1), across))
    wall = np.abs(across[:, 1]) < 0.5
    normals = np.where(wall[:, None, None], from_axis * facing[:, None, None], across[:, None, :])
    return split_vertices(mesh), normals.reshape(-1, 3)


def sheets():
    """Opaque sheets in one plane, in a uniform environment: what is seen of a matte sheet is its color."""
    wall, label, stamp = np.array([0.8, 0.5, 0.2]), np.array([0.1, 0.3, 0.9]), np.array([0.3, 0.9, 0.5])
    rule = ("They lie in exactly the same plane. What comes later in the document (depth first) lies on top, and where it does not cover, "
            "the next one is seen.")
    others = "glTF does not say what is seen where sheets coincide. Renderers that take the hit that comes first show one or the other by chance, often in stripes."
    why = "a matte sheet in a uniform environment is exact; the margin is for single precision."
    source = "closed form: coverage, and albedo in a uniform environment"
    half = 0.05

    def matte(color, alpha=1.0, **more):
        own = surface(color, 1.0, {"KHR_materials_specular": {"specularFactor": 0}}, doubleSided=True)
        own["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha
        own["pbrMetallicRoughness"].update(more.pop("pbr", {}))
        return {**own, **more}

    def case_of(name, title, tests, text, texels, mode, below=False, top=None):
        """A wall and a label of two texels that differ in alpha, on it or below it in the document."""
        case = Case(name, title, ["sheets in one plane"] + tests, text + " " + rule, spp=2048 if top else 1024).under(1)
        texture = {"baseColorTexture": {"index": case.document.texture([[(255, 255, 255, alpha) for alpha in texels]])}}
        mesh = plate(half, 0.0)
        uvs = [[0.5 + 0.5 * float(x) / half, 0.5] for x in mesh[0][:, 0]]
        base = lambda: case.document.add(plate(2 * half, 0.0), matte(wall), "wall")
        if not below:
            base()
        case.document.add(mesh, matte(label, pbr=texture, alphaMode=mode), "label", uvs)
        if below:
            base()
        if top is not None:
            case.document.add(plate(1.5 * half, 0.0), matte(stamp, top, alphaMode="BLEND"), "stamp")
        case.document.camera(DOWN, 0.9 * half, distance=0.5)
        case.others = others
        # The camera looks down and +x is up in the picture.
        parts = (("left texel, below", [0, 10, 16, 6], texels[0] / 255), ("right texel, above", [0, 0, 16, 6], texels[1] / 255))
        return case, parts, lambda where, region, right: case.expect(where, right, source, 0.003, why, region)

    over = lambda above, alpha, under: alpha * above + (1 - alpha) * under
    case, parts, expected = case_of("label-mask", "A label with holes on a wall", ["alpha"],
                                    "A label in alpha mode MASK on an opaque wall; the alpha of its left texel is 100/255, a hole, that of its right one "
                                    "200/255, which covers.",
                                    (100, 200), "MASK")
    for where, region, alpha in parts:
        covers = alpha >= 0.5
        expect = expected(where, region, label if covers else wall)
        expect.symptom(wall if covers else label, "the wall lies on top of the label" if covers else "the hole is not there: alpha is ignored, or the wall is not found below it")
        expect.symptom(over(label, alpha, wall), "alpha is taken for coverage, as in mode BLEND")
        expect.symptom((wall + label) / 2, "the one or the other is seen, by chance")
        expect.symptom([1, 1, 1], "one looks through both: what is behind the hole in the same plane is skipped, and the environment is seen")
        expect.symptom([0, 0, 0], "the sheet shades itself, or the other one")
    yield case

    alphas, cover = (51, 204), 0.5
    case, parts, expected = case_of("label-blend", "Two labels that let part of the wall through", ["alpha"],
                                    "A label in alpha mode BLEND on an opaque wall, alpha 0.2 in its left texel and 0.8 in its right one, and a stamp of "
                                    "alpha 0.5 on both.", alphas, "BLEND", top=cover)
    for where, region, alpha in parts:
        right = over(stamp, cover, over(label, alpha, wall))
        expect = expected(where, region, right)
        expect.symptom(over(label, alpha, over(stamp, cover, wall)), "the stamp lies below the label: the order is turned round, or comes from the order in which they are hit")
        expect.symptom(wall, "the wall lies on top of both")
        expect.symptom(stamp, "alpha is ignored: the stamp covers all")
        expect.symptom(over(stamp, cover, label), "the alpha of the label is ignored")
        expect.symptom(over(stamp, cover, wall), "the label is skipped: light goes on behind the first two sheets")
        expect.symptom(over(stamp, cover, np.ones(3)), "what is behind the stamp in the same plane is skipped, and the environment is seen")
        expect.symptom(cover * stamp + (1 - cover) ** 2 * (alpha * label + (1 - alpha) ** 2 * wall),
                       "light is covered twice: on its way to a sheet below, and on its way back")
        alpha_srgb = ((alpha + 0.055) / 1.055) ** 2.4
        expect.symptom(over(stamp, cover, over(label, alpha_srgb, wall)), "alpha is decoded from sRGB; it is linear")
        expect.symptom([0, 0, 0], "the sheets shade each other")
    yield case

    case, parts, expected = case_of("label-below", "A wall that was put over a label", ["alpha"],
                                    "The label of alpha 100/255 and 200/255 in mode MASK comes first, the opaque wall later: nothing of the label is seen.",
                                    (100, 200), "MASK", below=True)
    expect = expected("everything", None, wall)
    expect.symptom((label + wall) / 2, "the label lies on top: materials with alpha are drawn last, or nearer sheets are those of lower index")
    expect.symptom((label + 3 * wall) / 4, "the one or the other is seen, by chance")
    expect.symptom([0, 0, 0], "the sheets shade each other")
    yield case
