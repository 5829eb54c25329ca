"""One body described in many ways: scales, meshes, priorities, textures, and the extensions of Khronos."""
import numpy as np

import truth
from case import Case
from document import inside_out, medium, number, plate, slab, split_vertices, surface
from media import ALBEDO, G, IOR, SIBLING, TAU
from slabs import CLOSED, HALF_WIDTH, ROUNDING, TABLE, THICKNESS, WHY, absorbed, coefficients, mistakes, stage, tabulated

NO_PRIORITIES = ("Mitsuba 3 and Cycles have no priorities. In Mitsuba each surface sets the medium of its own side: an overlap holds what was entered "
                 "last, and light that leaves one body is in none, though still in the other; surfaces within a medium reflect. Cycles adds the "
                 "coefficients of all volumes around a point, and its surfaces reflect, too.")


def sibling(name, title, text, tests, thickness=THICKNESS, scale=1.0, build=None, **material):
    """The slab of `SIBLING`, described in another way."""
    half_width = HALF_WIDTH * thickness / THICKNESS
    case = stage(Case(name, title, tests, text, same_as=SIBLING), "R", thickness, half_width)
    a, s = coefficients(TAU, ALBEDO, thickness)
    expect = tabulated(case, TAU, ALBEDO, G, IOR)
    build(case, slab(thickness / scale, half_width / scale), a, s, expect)
    return case


def invariances():
    def wrong(expect, factor, says):
        """What the coefficients times a factor would show."""
        seen = [truth.simulate(TAU * factor, a, G, IOR)[0] for a in ALBEDO]
        expect.symptoms = [(m, t) for m, t in expect.symptoms if t != says]
        expect.symptom(seen, says)
        # What is said here is more to the point: it comes first.
        expect.symptoms.insert(0, expect.symptoms.pop())

    def density(case, mesh, a, s, expect):
        case.document.add(mesh, medium(4 * a, 4 * s, G, IOR, densityFactor=0.25), "slab")
        wrong(expect, 4.0, "densityFactor is ignored")
        wrong(expect, 16.0, "the coefficients are divided by densityFactor")

    yield sibling("density", "Density", "Coefficients four times as large, and `densityFactor` 0.25.", ["density"], build=density)

    def scaled(case, mesh, a, s, expect):
        case.document.add(mesh, medium(a, s, G, IOR), "slab", scale=[8, 8, 8])
        wrong(expect, 0.125, "the scale of the node multiplies lengths, but coefficients are taken per unit of the mesh")
        wrong(expect, 8.0, "the scale of the node multiplies the coefficients, too")

    yield sibling("node-scale", "Scale of the node", "A mesh an eighth as large in a node of scale 8. Coefficients are per metre of the "
                  "world, so nothing changes.", ["scale"], scale=8.0, build=scaled)

    def plain(case, mesh, a, s, expect):
        case.document.add(mesh, medium(a, s, G, IOR), "slab")

    for name, thickness, title in (("unit-small", 1e-5, "A slab of 10 µm"), ("unit-large", 10.0, "A slab of 10 m")):
        yield sibling(name, title, f"Everything is {thickness / THICKNESS:g} times as large, coefficients are as much smaller. A renderer with an "
                      "absolute epsilon, or a cap on coefficients or distances, shows it here.", ["scale"], thickness, build=plain)

    def split(case, mesh, a, s, expect):
        case.document.add(split_vertices(mesh), medium(a, s, G, IOR), "slab")

    yield sibling("split-vertices", "Split vertices", "Every triangle has three vertices of its own, as exporters write flat shading. The mesh is "
                  "closed all the same: equal positions are one.", ["mesh"], build=split)

    def reverse(case, mesh, a, s, expect):
        case.document.add(inside_out(mesh), medium(a, s, G, IOR), "slab")
        expect.symptom([0, 0, 0], "the medium is thought to be outside of the slab")

    yield sibling("inside-out", "Inside-out mesh", "All triangles are wound the other way. The medium is inside the mesh whichever way they "
                  "face.", ["mesh"], build=reverse)

    def opened(case, mesh, a, s, expect):
        points, triangles = mesh
        # The first two triangles are the side at −x.
        case.document.add((points, triangles[2:]), medium(a, s, G, IOR), "slab")

    case = sibling("open-mesh", "Open mesh", "One side of the slab is missing, a hundred thicknesses from what is seen. A mesh that is not closed is "
                   "reported and rendered: light enters where it passes a triangle from the front and leaves where it passes one from the back. "
                   "So nothing changes in the middle.", ["mesh"], build=opened)
    yield case

    def instanced(case, mesh, a, s, expect):
        index = case.document.mesh(mesh, medium(a, s, G, IOR))
        case.document.node(name="the other", mesh=index, translation=[0, -0.2, 0])
        # A reflection turns triangles inside out; half a turn about x puts the bottom on top.
        case.document.node(name="slab", mesh=index, rotation=[1, 0, 0, 0], scale=[-1, 1, 1], translation=[0, number(-THICKNESS), 0])

    yield sibling("instancing", "Instancing", "One mesh in two nodes; the one that is seen is turned over and mirrored. Two nodes with one mesh "
                  "are two bodies.", ["mesh", "scale"], build=instanced)

    def everything(case, mesh, a, s, expect):
        decoy = {"KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.002, "attenuationColor": [0.9, 0.1, 0.1]},
                 "KHR_materials_transmission": {"transmissionFactor": 1},
                 "KHR_materials_ior": {"ior": 1.1},
                 "KHR_materials_scatter": {"scatterStrengthFactor": 1, "multiscatterColorFactor": [0.1, 0.1, 0.9]},
                 "KHR_materials_volume_scatter": {"multiscatterColorFactor": [0.9, 0.9, 0.1]}}
        case.document.add(mesh, medium(a, s, G, IOR, more=decoy), "slab")

    yield sibling("precedence", "Precedence over the Khronos extensions", "The material also carries KHR_materials_volume, _scatter, "
                  "_volume_scatter and _ior, all with other numbers. This extension wins and nothing is added up.", ["precedence"], build=everything)


def layers():
    """Overlapping and nested clear media: closed forms of piles of layers."""
    d, n = THICKNESS, 1.5
    a, b = np.array([0.2, 0.5, 1.0]), np.array([1.0, 0.5, 0.1])
    face = (truth.fresnel(1.0, n), 1 - truth.fresnel(1.0, n))

    def seen(ways):
        return [sum(truth.pile([face, (0.0, np.exp(-(ways[0] * x + ways[1] * y))), face])) for x, y in zip(a, b)]

    for name, first, second, ways in (("priority-upper", 1, 0, (2, 1)), ("priority-lower", -1, 2, (1, 2))):
        case = stage(Case(name, "Priority of overlapping media: " + name.split("-")[1], ["priority", "absorption"],
                          "Two absorbing slabs of index 1.5, each two centimetres thick, overlap by one. The medium with the higher priority "
                          f"fills the overlap: here the {name.split('-')[1]} one (priorities {first} and {second}). Since the indices are equal, "
                          "nothing is reflected between them.", spp=256), "both", thickness=3 * d)
        case.document.add(slab(2 * d, HALF_WIDTH), medium(a / d, ior=n, priority=first), "upper")
        case.document.add(slab(2 * d, 0.9 * HALF_WIDTH, -d), medium(b / d, ior=n, priority=second), "lower")
        expect = case.expect("both", seen(ways), CLOSED, ROUNDING, WHY)
        case.others = NO_PRIORITIES
        other = (1, 2) if ways == (2, 1) else (2, 1)
        expect.symptom(seen(other), "the other medium fills the overlap: the order of priorities is turned round")
        expect.symptom(seen((2, 2)), "in the overlap the coefficients are added up")
        expect.symptom(seen((1, 1)), "nothing fills the overlap")
        expect.symptom([truth.without_priorities(x, y, n) for x, y in zip(a, b)],
                       "there are no priorities: each surface sets the medium of its own side, so light that leaves one body is in none")
        yield case
    case = stage(Case("nesting", "A medium inside another", ["priority", "Fresnel", "absorption"],
                      "A plate of index 2 lies inside a slab of index 1.33; neither says a priority, so the smaller one fills its place. The "
                      "boundary between them reflects as one of relative index 2/1.33.", spp=512), "both", thickness=3 * d)
    outer, inner = np.array([0.3, 0.1, 0.5]), np.array([0.1, 0.6, 1.0])
    case.document.add(slab(3 * d, HALF_WIDTH), medium(outer / d, ior=1.33), "outer")
    case.document.add(slab(d, 0.9 * HALF_WIDTH, -d), medium(inner / d, ior=2), "inner")

    def nested(outer_ways, inner_ways, f_in):
        f_out = truth.fresnel(1.0, 1.33)
        pair = lambda f: (f, 1 - f)
        way = lambda x: (0.0, np.exp(-x))
        return [sum(truth.pile([pair(f_out), way(o * outer_ways / 2), pair(f_in), way(o * (2.0 if inner_ways == 2 else 0) / 2 + i), pair(f_in),
                                way(o * outer_ways / 2), pair(f_out)])) for o, i in zip(outer, inner)]

    right = nested(2, 1, truth.fresnel(1.0, 2 / 1.33))
    expect = case.expect("both", right, CLOSED, ROUNDING, WHY)
    expect.symptom(nested(2, 1, truth.fresnel(1.0, 2.0)), "the inner boundary refracts as if air were around it: its index is not divided by that of the medium outside")
    expect.symptom(nested(2, 2, truth.fresnel(1.0, 2 / 1.33)), "inside the inner body both media absorb")
    f = truth.fresnel(1.0, 1.33)
    expect.symptom([sum(truth.pile([(f, 1 - f), (0.0, np.exp(-3 * o)), (f, 1 - f)])) for o in outer], "the inner body is not there: the outer one fills its place")
    case.others = "Cycles adds the coefficients of all volumes around a point, so inside the inner body both absorb."
    yield case


def looks():
    """Textures, tint, thin walls."""
    d, n = THICKNESS, 1.5
    case = stage(Case("texture", "Textured coefficients", ["texture", "absorption"],
                      "Absorption is textured: the left texel is (51, 128, 204), the right one (255, 51, 128), linear data over 255, looked up at the "
                      "nearest texel. Two regions are measured, away from the edge between them.", spp=2048), "both")
    tau = np.array([2.0, 1.5, 1.0])
    left, right = np.array([51, 128, 204]) / 255, np.array([255, 51, 128]) / 255
    texels = [[(51, 128, 204, 255), (255, 51, 128, 255)]]
    mesh = slab(d, HALF_WIDTH)
    uvs = [[0.5 + 0.5 * float(x) / HALF_WIDTH, 0.5] for x in mesh[0][:, 0]]
    texture = case.document.texture(texels)
    case.document.add(mesh, medium(tau / d, ior=n, absorptionTexture={"index": texture}), "slab", uvs)
    case.others = ("The adapters for Mitsuba 3 and Cycles leave textures of coefficients out: neither renderer has a volume that follows the nearest "
                   "point of the surface.")
    # The camera looks down and +x is up in the picture.
    for name, factor, other, region in (("left texel, below", left, right, [0, 10, 16, 6]), ("right texel, above", right, left, [0, 0, 16, 6])):
        seen = lambda f: [sum(truth.clear(t * x, n)) for t, x in zip(tau, f)]
        expect = case.expect(name, seen(factor), CLOSED, ROUNDING, WHY, region)
        expect.symptom(seen(np.where(factor <= 0.04045, factor / 12.92, ((factor + 0.055) / 1.055) ** 2.4)), "texels are decoded from sRGB; they are linear")
        expect.symptom(seen([1, 1, 1]), "the texture is ignored")
        expect.symptom(seen(other), "the texels are swapped: u runs the other way, or the picture is upside down")
        expect.symptom(seen((left + right) / 2), "the texture is averaged: its sampler asks for the nearest texel")
    yield case

    case = stage(Case("tint", "Base color", ["base color", "Fresnel"],
                      "Clear glass with a base color of (0.8, 0.5, 0.2): it multiplies light at each crossing of the boundary and never what is "
                      "reflected, outside or inside.", spp=1024), "both")
    tint = np.array([0.8, 0.5, 0.2])
    case.document.add(slab(d, HALF_WIDTH), medium(ior=n, color=tint), "slab")
    expect = case.expect("the slab", [sum(truth.clear(0.0, n, tint=c)) for c in tint], CLOSED, ROUNDING, WHY)
    f = truth.fresnel(1.0, n)
    expect.symptom([1, 1, 1], "the base color is ignored")
    expect.symptom([f + (1 - f) ** 2 * c * (1 + f) / (1 - f * f) for c in tint], "the base color counts once a way through, not at each crossing")
    expect.symptom(tint, "the base color is shown as it is")
    expect.symptom([c * f + (c * (1 - f)) ** 2 / (1 - c * f) for c in tint], "reflections are tinted, too")
    expect.symptom([f + c * c * (1 - f) ** 2 * (1 + f * c) / (1 - f * f * c * c) for c in tint], "reflections inside are tinted, too")
    case.others = ("Cycles' glass multiplies by its color what it reflects, too, inside and outside: 0.641, 0.255 and 0.045.")
    yield case

    volume = lambda thickness: {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": n},
                                "KHR_materials_volume": {"thicknessFactor": thickness, "attenuationDistance": number(d), "attenuationColor": [0.2, 0.5, 0.8]}}
    color = np.array([0.2, 0.5, 0.8])
    case = stage(Case("khr-volume", "KHR_materials_volume, volumetric", ["Khronos", "absorption", "Fresnel"],
                      "A closed slab with `thicknessFactor` above 0: attenuation −ln(attenuationColor)/attenuationDistance along the real way "
                      "inside, which is just the attenuation distance.", spp=256), "both")
    case.document.add(slab(d, HALF_WIDTH), surface(extensions=volume(1.0)), "slab")
    tau = -np.log(color)
    expect = case.expect("the slab", list(sum(truth.clear(tau, n))), CLOSED, ROUNDING, WHY)
    absorbed(expect, lambda t: sum(truth.clear(t, n)), tau, n, 1.0)
    expect.symptom(sum(truth.clear(100 * tau, n)), "the way is `thicknessFactor`, not the way inside the body")
    yield case

    case = stage(Case("thin-wall", "Thin-walled transmission", ["Khronos", "thin wall"],
                      "One sheet of KHR_materials_transmission without a volume, seen at a cosine of 0.6 over a black plate: a thin wall. Light goes "
                      "straight on and nothing attenuates, so over the black plate only the reflection of one surface is seen. glTF has it by "
                      "Schlick's formula: F0 + (1 − F0)(1 − cos θ)⁵, F0 = ((n − 1)/(n + 1))².", spp=3072), "R", cos=0.6)
    sheet = surface(extensions={"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": n}}, doubleSided=True)
    case.document.add(plate(HALF_WIDTH, 0.0), sheet, "sheet")
    f0 = truth.fresnel(1.0, n)
    schlick, exact = f0 + (1 - f0) * 0.4**5, truth.fresnel(0.6, n)
    expect = case.expect("the sheet", [schlick] * 3, "glTF 2.0, Appendix B (Schlick)", 0.005, "rounding.")
    expect.symptom([exact] * 3, "Fresnel's equations instead of Schlick's formula: nearer to nature, but not what glTF says")
    expect.symptom([2 * exact / (1 + exact)] * 3, "a sheet of glass with two surfaces: light is reflected between them")
    expect.symptom([2 * schlick / (1 + schlick)] * 3, "a sheet with two surfaces, each by Schlick's formula: light is reflected between them")
    expect.symptom([f0] * 3, "reflectance does not depend on the angle")
    expect.symptom([1, 1, 1], "the sheet is opaque and white: transmission is ignored")
    case.others = ("Renderers of physical glass reflect by Fresnel's equations and show 0.0645 here, which is 29 % more than glTF's formula. Mitsuba's "
                   "`thindielectric` also has two surfaces with reflections between them: 0.1212.")
    yield case


def khronos():
    """Scattering by the drafts of Khronos."""
    albedo, g = np.array([0.5, 0.9, 0.99]), 0.5
    d, n, tau = THICKNESS, 1.5, 2

    def multiple(albedo, g):
        s = np.sqrt((1 - albedo) / (1 - g * albedo))
        return (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s)

    def inverse(rho, g):
        s = 4.09712 + 4.20863 * rho - np.sqrt(9.59217 + 41.6808 * rho + 17.7126 * rho * rho)
        return (1 - s * s) / (1 - g * s * s)

    for name, extension, key, in_mapping in (("khr-scatter", "KHR_materials_scatter", "multiscatterColorFactor", g),
                                             ("khr-volume-scatter", "KHR_materials_volume_scatter", "multiscatterColorFactor", 0.0)):
        case = stage(Case(name, f"{extension} (draft)", ["Khronos", "scattering", "anisotropy"],
                          f"The medium is given by KHR_materials_volume, whose attenuation is the total extinction σt, and {extension}, whose multi-scatter "
                          "color ρ gives the albedo by s = 4.09712 + 4.20863ρ − √(9.59217 + 41.6808ρ + 17.7126ρ²), ρss = (1 − s²)/(1 − g s²)"
                          + ("." if in_mapping else ", there with g = 0 whatever the anisotropy is.")
                          + " The numbers are chosen so that the albedos are 0.5, 0.9 and 0.99.", spp=3072), "R")
        rho = multiple(albedo, in_mapping)
        # The published formulas are inverse to each other to some 1e-4: the slab's albedo is what the way there gives.
        own = {key: [number(round(r, 6)) for r in rho], "scatterAnisotropy": g}
        if name == "khr-scatter":
            own["scatterStrengthFactor"] = 1
        extensions = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": n}, extension: own,
                      "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": number(d / tau), "attenuationColor": [number(np.exp(-1))] * 3}}
        case.document.add(slab(d, HALF_WIDTH), surface(extensions=extensions), "slab")
        expect = case.expect("the slab", [truth.slab(tau, float(a), g, n)["normal"][0] for a in albedo], TABLE, 0.008,
                             "the published fit and its inverse agree to about 0.1 % in albedo, which is up to 0.5 % of the reflectance, and rounding.")
        mistakes(case, expect, tau, albedo, g, n)
        seen = lambda a, tau=tau: [truth.simulate(t, x, g, n)[0] for t, x in zip(np.broadcast_to(tau, 3), a)]
        expect.symptom(seen(rho), "the multi-scatter color is taken for the single-scattering albedo")
        expect.symptom(seen(inverse(rho, g if in_mapping == 0 else 0.0)), "g is " + ("left out of" if in_mapping else "used in") + " the mapping from multi-scatter color to albedo")
        expect.symptom(seen(albedo / (1 + albedo), tau * (1 + albedo)), "attenuation is taken for absorption, and scattering is added to it")
        yield case
