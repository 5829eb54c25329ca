"""All cases of the suite, in the order of the report."""
import numpy as np

import truth
from case import Case
from document import (black, box, icosphere, inside_out, look_along, medium, number, plate, slab, split_vertices, surface)
from slabs import (CLOSED, DOWN, HALF_WIDTH, ROUNDING, TABLE, THICKNESS, WHY, absorbed, absorbing, coefficients, mistakes,
                   scattering, stage, tabulated)

# The slab of the invariance cases, whose numbers are those of `absorption-in-scattering`.
TAU, ALBEDO, G, IOR = 2, [0.5, 0.9, 0.99], 0.0, 1.5
SIBLING = "albedo"
WALK = "converged random walk of nephrite"


def furnaces():
    text = """A sphere that absorbs nothing, in a uniform environment of radiance 1, cannot be seen: every pixel is 1, in every
channel, whatever scatters inside. Red, green and blue scatter differently ({sigma}), so weights that gain or lose light show as
color."""
    for name, title, roughness, ior, g, spp, tolerance in (
        ("furnace-smooth", "Colored white furnace, smooth", 0.0, 1.5, 0.3, 2048, 0.003),
        ("furnace-forward", "Colored white furnace, forward scattering", 0.0, 1.33, 0.9, 2048, 0.003),
        ("furnace-rough-03", "Colored white furnace, roughness 0.3", 0.3, 1.5, 0.3, 2048, 0.005),
        ("furnace-rough-07", "Colored white furnace, roughness 0.7", 0.7, 1.5, 0.3, 2048, 0.005),
    ):
        sigma_s = [50, 100, 200]
        case = Case(name, title, ["energy", "spectral weights"] + (["roughness"] if roughness else []),
                    text.format(sigma="σs = 50, 100, 200 per metre, a radius of 2 cm"), spp=spp).under(1)
        case.document.add(icosphere(0.02, 4), medium((0, 0, 0), sigma_s, g, ior, roughness), "sphere")
        case.document.camera((-0.4, -0.3, -0.9), 0.013, distance=0.2)
        why = "a furnace is exact; the margin is for paths that are cut off."
        if roughness:
            case.sweep = ("roughness", "roughness of the boundary, no absorption", [roughness])
            why = "the energy of the rough boundary comes from tables, exact to 0.3 %."
        expect = case.expect("the sphere", [1, 1, 1], "exact: nothing absorbs", tolerance, why)
        expect.symptom([0, 0, 0], "the medium is opaque, or paths are cut off before they leave")
        n = ior
        expect.symptom([n * n] * 3, "η² too much at one crossing")
        expect.symptom([1 / n**2] * 3, "1/η² too much at one crossing")
        lossy = {0.3: [0.948, 0.942, 0.939], 0.7: [0.587, 0.567, 0.555]}.get(roughness)
        if lossy:
            # As nephrite shows with `--microfacet single`, to 0.3 %.
            expect.symptom(lossy, "single-scattering microfacets: light that would meet the surface twice is lost at each of many crossings")
        if roughness:
            case.others = ("Renderers whose rough dielectric scatters once on the microscopic surface lose light at each "
                           "crossing; inside a body it crosses many times. nephrite does so with `--microfacet single`.")
        yield case


def absorption():
    yield absorbing("absorption", "Absorption along a straight way", ["absorption", "Fresnel"],
                    "A slab of index 1.5 that only absorbs, seen along its normal in a uniform environment of radiance 1. What is seen "
                    "is what is reflected and what passes, Σ over all internal reflections. The three channels are three coefficients.",
                    [0.2, 1.0, 2.0], 1.5, sweep=("absorption", "optical thickness σa d", [0.2, 1.0, 2.0]))
    yield absorbing("absorption-oblique", "Absorption along a refracted way", ["absorption", "Fresnel", "refraction"],
                    "The same slab seen at a cosine of 0.6: the way inside follows Snell's law, and reflectance is that of unpolarised "
                    "light (averaged at each boundary).", [0.2, 1.0, 2.0], 1.5, cos=0.6)
    yield scattering("absorption-strong", "Albedo of a thick slab", ["absorption", "scattering", "Fresnel"],
                     "A thick slab of index 1.5 whose channels absorb differently; the reflectance depends on many scatterings and on "
                     "internal reflection.", 8, [0.5, 0.9, 0.99], 0.0, 1.5,
                     sweep=("albedo-thick", "single-scattering albedo σs/σt at σt d = 8", [0.5, 0.9, 0.99]))
    yield scattering(SIBLING, "Absorption in a scattering slab", ["absorption", "scattering", "Fresnel"],
                     "A slab of index 1.5 and optical thickness 2 whose channels differ in albedo. This is the slab that the cases on "
                     "scale, density, instancing and meshes draw in other ways.", TAU, ALBEDO, G, IOR,
                     sweep=("albedo", "single-scattering albedo σs/σt at σt d = 2", ALBEDO))


def scatterings():
    text = "A slab of index 1.33 that does not absorb. The three channels are three scattering coefficients."
    yield scattering("scattering", "Scattering without absorption, reflected", ["scattering", "Fresnel"], text,
                     [1, 2, 8], 1.0, 0.0, 1.33, spp=2048, sweep=("scattering", "optical thickness σs d, reflectance", [1, 2, 8]))
    yield scattering("scattering-passed", "Scattering without absorption, transmitted", ["scattering", "Fresnel", "area light"],
                     text + " A plate of radiance 1 below it shines through.", [1, 2, 8], 1.0, 0.0, 1.33, side="T", spp=3072,
                     sweep=("scattering-passed", "optical thickness σs d, transmittance", [1, 2, 8]))
    yield scattering("scattering-oblique", "Scattering slab seen obliquely", ["scattering", "Fresnel", "refraction"],
                     "A slab of index 1.5 seen at a cosine of 0.6.", [0.5, 2, 8], [0.9, 0.99, 0.99], 0.0, 1.5, cos=0.6, spp=2048)
    for name, g in (("backward", -0.5), ("isotropic", 0.0), ("forward", 0.5), ("strong", 0.9)):
        yield scattering(f"anisotropy-{name}", f"Anisotropy {g:g}", ["scattering", "anisotropy"],
                         f"A slab of index 1, so that nothing but the phase function matters: Henyey–Greenstein with g = {g:g} between "
                         "directions of travel. The channels are optical thicknesses 8, 8 and 32 of albedo 0.99, 1 and 0.99.",
                         [8, 8, 32], [0.99, 1.0, 0.99], g, 1.0, spp=2048 if g == 0.9 else 1024,
                         sweep=("anisotropy", "anisotropy g", [g]))
    yield scattering("anisotropy-passed", "Anisotropy 0.9, transmitted", ["scattering", "anisotropy", "area light"],
                     "What passes through a slab of index 1.33 that scatters forward; a plate of radiance 1 shines from below.",
                     [1, 2, 8], [0.5, 0.9, 0.99], 0.9, 1.33, side="T", spp=2048)
    for ior in (1.0, 1.33, 1.5):
        yield scattering(f"ior-{100 * ior:.0f}", f"Index of refraction {ior:g}", ["Fresnel", "scattering"],
                         f"A scattering slab of index {ior:g} and optical thickness 8. A higher index reflects more from outside and "
                         "keeps more light in. The channels are albedos 0.9, 0.99 and 1.", 8, [0.9, 0.99, 1.0], 0.5, ior,
                         sweep=("index", "index of refraction", [ior]))


def glass():
    for ior in (1.33, 2.4):
        case = stage(Case(f"glass-{100 * ior:.0f}", f"Clear slab of index {ior:g}", ["Fresnel"],
                          "Both coefficients are zero: clear glass. Over a black plate the reflectance is 2F/(1 + F), F = ((n − 1)/(n + 1))².",
                          spp=4096 if ior < 2 else 1024), "R")
        case.document.add(slab(THICKNESS, HALF_WIDTH), medium(ior=ior), "slab")
        f = truth.fresnel(1.0, ior)
        expect = case.expect("the slab", [2 * f / (1 + f)] * 3, CLOSED, ROUNDING, WHY)
        expect.symptom([f] * 3, "only the first surface reflects: none inside, or light cannot cross the second boundary")
        expect.symptom([2 * f] * 3, "light from inside is not reflected a second time")
        expect.symptom([0] * 3, "the boundary does not reflect")
        expect.symptom([2 * 0.04 / 1.04] * 3, "the index is ignored: 1.5 is used")
        yield case


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
        other = (1, 2) if ways == (2, 1) else (2, 1)
        expect.symptom(seen(other), "the other medium fills the overlap: the order of priorities is turned round")
        expect.symptom(seen((2, 2)), "in the overlap the coefficients are added up")
        expect.symptom(seen((1, 1)), "nothing fills the overlap")
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
    expect.symptom(tint**2, "reflections are tinted, too")
    expect.symptom([f + c * c * (1 - f) ** 2 * (1 + f * c) / (1 - f * f * c * c) for c in tint], "reflections inside are tinted, too")
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
    case.others = "Renderers of physical glass reflect by Fresnel's equations and show 0.0645 here, which is 29 % more than glTF's formula."
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


def spheres():
    for name, g, n, channels in (("sphere-isotropic", 0.0, 1.33, ((0.5, 0.9), (2.0, 0.99), (8.0, 0.5))),
                                 ("sphere-forward", 0.8, 1.33, ((0.5, 0.5), (2.0, 0.9), (8.0, 0.99)))):
        radius = 0.02
        case = Case(name, f"Sphere with anisotropy {g:g}", ["scattering", "Fresnel", "curved boundary"] + (["anisotropy"] if g else []),
                    f"A sphere of index {n:g} in a uniform environment. The three channels are optical radii {channels[0][0]:g}, {channels[1][0]:g} and "
                    f"{channels[2][0]:g} of albedo {channels[0][1]:g}, {channels[1][1]:g} and {channels[2][1]:g}. The square around it is measured: 1 − π/4 of it is the "
                    "environment.", size=32, spp=512).under(1)
        tau, albedo = (np.array([c[k] for c in channels]) for k in (0, 1))
        case.document.add(icosphere(radius, 4, True), medium(tau * (1 - albedo) / radius, tau * albedo / radius, g, n), "sphere")
        case.document.camera((0.3, -0.5, -0.8), radius, distance=0.2)
        share = np.pi / 4
        known = [truth.sphere(float(t), float(a), g, n) for t, a in zip(tau, albedo)]
        expect = case.expect("the square", [1 - share + share * r for r, _ in known], "Monte Carlo of a sphere, independent of nephrite", 0.004,
                             "the sphere is a polyhedron of 5120 triangles with the volume of the ball.", standard_error=[share * se for _, se in known])
        without = lambda g, n: [1 - share + share * truth.sphere(float(t), float(a), g, n)[0] for t, a in zip(tau, albedo)]
        expect.symptom(without(g, 1.0), "the boundary is not there: index 1")
        if g:
            expect.symptom(without(0.0, n), "g is ignored: scattering is isotropic")
        expect.symptom([1, 1, 1], "absorption is ignored")
        yield case
    radius, tau = 0.02, np.array([0.2, 1.0, 2.0])
    case = Case("camera-inside", "Camera inside the medium", ["camera", "absorption"],
                "The camera is in the middle of a sphere of index 1 that absorbs; it sees the environment through one radius of medium, "
                "e^(−σa r).", spp=64).under(1)
    case.document.add(icosphere(radius, 4, True), medium(tau / radius, ior=1), "sphere")
    case.document.perspective((0.3, -0.5, -0.8), 0.6)
    expect = case.expect("everything", list(np.exp(-tau)), "closed form: Beer–Lambert", 0.005,
                         "the sphere is a polyhedron; its radius varies by 0.2 %.")
    expect.symptom([1, 1, 1], "the medium around the camera is not known: absorption begins at the first boundary")
    expect.symptom(np.exp(-2 * tau), "the way is that of a whole diameter")
    expect.symptom(1 / np.exp(-tau), "leaving the sphere is taken for entering it")
    yield case
    case = Case("camera-inside-scattering", "Camera inside a scattering medium", ["camera", "scattering", "energy"],
                "The camera is in the middle of a sphere of index 1 that scatters and does not absorb: it sees 1 in every direction.", spp=768).under(1)
    case.document.add(icosphere(radius, 3), medium((0, 0, 0), tau * 4 / radius, ior=1), "sphere")
    case.document.perspective((0.3, -0.5, -0.8), 0.6)
    expect = case.expect("everything", [1, 1, 1], "exact: nothing absorbs", 0.003, "rounding.")
    expect.symptom(np.exp(-4 * tau), "only light that was not scattered is seen")
    yield case


def lights():
    """Each kind of light onto one slab of index 1: its scattered radiance is tabulated."""
    tau, albedo, g = [1, 2, 8], [0.9, 0.9, 0.99], 0.0
    brdf = [truth.slab(t, a, g, 1.0)["brdf"] for t, a in zip(tau, albedo)]
    text = ("A slab of index 1, so that light reaches the events inside in straight lines. The camera looks at a cosine of 0.6; {how}. The radiance "
            "is that irradiance times the tabulated BRDF of the scattered light at that angle.")
    distance = 20.0

    def case_of(name, title, how, irradiance, tests, spp=1536):
        case = Case(f"light-{name}", title, ["lights", "scattering"] + tests, text.format(how=how), spp=spp)
        case.side, case.cos = "R", 0.6
        a, s = coefficients(tau, albedo)
        case.document.add(slab(THICKNESS, HALF_WIDTH), medium(a, s, g, 1.0), "slab")
        case.document.add(plate(1.2 * HALF_WIDTH, -1.1 * THICKNESS), black(), "black plate")
        case.document.camera((0.8, -0.6, 0), 0.1 * THICKNESS, distance=0.5)
        right = np.array(brdf) * irradiance
        expect = case.expect("the slab", list(right), TABLE, 0.004,
                             "irradiance varies by less than 0.1 % over the part of the slab that scatters to the camera.")
        expect.symptom(right * np.pi, "π too much: irradiance is taken for radiance, or a BRDF lacks 1/π")
        expect.symptom(right / np.pi, "π too little")
        expect.symptom(right * 4 * np.pi, "4π too much: the phase function is not normalised, or intensity is taken for power")
        expect.symptom(right / (4 * np.pi), "4π too little: intensity is taken for power over the whole sphere")
        expect.symptom([0, 0, 0], "the light does not reach the inside of a medium: shadow rays stop at its boundary")
        return case, expect, right

    case, expect, right = case_of("directional", "Directional light", "a directional light of 3 lx shines along the normal", 3.0, [])
    case.document.light({"type": "directional", "intensity": 3}, DOWN)
    yield case
    case, expect, right = case_of("point", "Point light", f"a point light of 1200 cd hangs {distance:g} m above: 3 lx", 3.0, [])
    case.document.light({"type": "point", "intensity": 1200}, DOWN, (0, distance, 0))
    expect.symptom(right * distance**2, "no decrease with the square of the distance")
    expect.symptom(right * distance, "light decreases with the distance, not with its square")
    yield case
    case, expect, right = case_of("spot", "Spot light", f"a spot light of 1200 cd hangs {distance:g} m above: 3 lx on its axis", 3.0, [])
    case.document.light({"type": "spot", "intensity": 1200, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}}, DOWN, (0, distance, 0))
    expect.symptom(right * distance**2, "no decrease with the square of the distance")
    yield case
    side = 0.5
    irradiance = 3.0
    radiance = irradiance * distance**2 / side**2
    case, expect, right = case_of("area", "Small area light", f"a panel of {100 * side:g} cm faces it from {distance:g} m: radiance {radiance:g}, 3 lx", irradiance, ["area light"])
    case.document.add(plate(side / 2, distance, up=False), black([radiance] * 3), "panel")
    expect.symptom([0, 0, 0], "the panel shines to the other side only")
    expect.symptom(right * 2, "the panel is taken for twice as large")
    yield case
    case, expect, right = case_of("oblique", "Directional light, oblique", "a directional light of 3 lx (across its beam) comes at a cosine of 0.6, the camera looks along the normal", 1.8, [])
    # Reciprocity: BRDF(0.6 → 1) = BRDF(1 → 0.6); the irradiance of the slab has a cosine of 0.6.
    case.document.json["nodes"] = [n for n in case.document.json["nodes"] if n["name"] != "camera"]
    case.document.json["scenes"][0]["nodes"] = list(range(len(case.document.json["nodes"])))
    case.document.camera(DOWN, 0.1 * THICKNESS, distance=0.5)
    case.document.light({"type": "directional", "intensity": 3}, (0.8, -0.6, 0))
    expect.symptom(right / 0.6, "the cosine of the light's angle is missing")
    expect.symptom(right * 0.6, "the cosine of the light's angle counts twice")
    yield case
    case = stage(Case("light-environment", "Brightness of the environment", ["lights", "scattering", "spectral weights"],
                      "The slab of index 1 in a uniform environment of radiance 0.25.", environment=None), "R", radiance=0.25)
    a, s = coefficients(tau, albedo)
    case.document.add(slab(THICKNESS, HALF_WIDTH), medium(a, s, g, 1.0), "slab")
    right = 0.25 * np.array([truth.slab(t, x, g, 1.0)["normal"][0] for t, x in zip(tau, albedo)])
    expect = case.expect("the slab", list(right), TABLE, ROUNDING, WHY)
    expect.symptom(4 * right, "the intensity of the environment is ignored")
    expect.symptom(0.25 * right, "the intensity of the environment counts twice")
    expect.symptom(np.pi * right, "π too much: irradiance is taken for radiance")
    expect.symptom(right / np.pi, "π too little")
    yield case


def pictures():
    """Scenes whose truth is the converged random walk."""
    why = "the reference is a random walk itself; its error is stated, the rest is rounding."

    def regions(case, names):
        for name, region in names:
            case.expect(name, None, WALK, 0.004, why, region)
        case.reference = "reference.exr"
        return case

    quarter = [("whole picture", None), ("upper left", [0, 0, 16, 16]), ("upper right", [16, 0, 16, 16]), ("lower left", [0, 16, 16, 16]), ("lower right", [16, 16, 16, 16])]
    for roughness in (0.3, 0.6):
        case = Case(f"rough-{10 * roughness:02.0f}", f"Rough sphere under a lamp, roughness {roughness:g}", ["roughness", "lights", "scattering"],
                    f"A sphere of index 1.5 and roughness {roughness:g} (α = {roughness**2:g}), lit from the upper left by a point light and weakly from all around. "
                    "The highlight, the light below the surface and what leaks to the dark side are measured in quarters.", size=32, spp=512).under(0.1)
        case.document.add(icosphere(0.02, 4), medium([20, 60, 200], [400, 400, 400], 0.3, 1.5, roughness), "sphere")
        case.document.camera((0, 0, -1), 0.022, distance=0.3)
        case.document.light({"type": "point", "intensity": 0.3}, DOWN, (-0.2, 0.2, 0.2))
        case.others = ("A rough boundary that scatters once on the microscopic surface loses light: the body is a few per cent darker.")
        yield regions(case, quarter)
    case = Case("beads", "Beads in amber", ["priority", "Fresnel", "absorption", "scattering"],
                "A sphere of clear absorbing amber with two scattering beads; one of them reaches through its surface and has the higher "
                "priority.", size=32, spp=768).under(1)
    case.document.add(icosphere(0.02, 4), medium([10, 25, 80], ior=1.54), "amber")
    case.document.add(icosphere(0.006, 3), medium([60, 18, 45], [900, 950, 900], 0.0, 1.61, priority=1), "bead", translation=[-0.006, 0.004, 0.004])
    case.document.add(icosphere(0.006, 3), medium([10, 60, 90], [900, 700, 500], 0.3, 1.4, priority=1), "bead outside", translation=[0.014, -0.008, 0.01])
    case.document.camera((0, 0, -1), 0.023, distance=0.3)
    yield regions(case, quarter)


def everything():
    for group in (furnaces, absorption, scatterings, glass, invariances, layers, looks, khronos, spheres, lights, pictures):
        yield from group()
