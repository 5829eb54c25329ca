"""Bodies whose surfaces coincide: pieces of one block, a drink in its glass, two bodies in one place; and parts wound inside out."""
import numpy as np

import truth
from case import Case
from descriptions import NO_PRIORITIES, sibling
from document import box, inside_out, joined, medium, revolved, slab
from media import ALBEDO, G, IOR, TAU
from slabs import CLOSED, DOWN, HALF_WIDTH, OBLIQUE, ROUNDING, THICKNESS, WHY, stage, unscaled

NO_GAPS = ("The pieces share faces to the bit. A boundary is there only where the medium changes, so nothing is reflected or refracted where "
           "pieces of equal index touch.")
FURNACE = "exact: nothing absorbs"
CUT_OFF = "a furnace is exact; the margin is for paths that are cut off."
BEER = "closed form: Beer–Lambert"
BEHIND = "both boundaries of a shared face are skipped, and light goes on behind it as if it were still in the first piece"
FILM = "a film of air is between the pieces"


def furnace(name, title, tests, text, mirrored, n):
    """A clear scene that cannot be seen, whose surface reflects `mirrored` where the camera looks; the camera is not there yet."""
    case = Case(name, title, tests + ["energy"], text, spp=512).under(1)
    expect = case.expect("everything", [1, 1, 1], FURNACE, 0.003, CUT_OFF)
    unscaled(expect, mirrored, n)
    expect.symptom([mirrored] * 3, "light that went in is lost: paths are trapped and cut off")
    return case, expect


def behind(expect, mirrored, n):
    """What is seen if light leaves a body that it is not in, and the scale of radiance stays what it was inside."""
    plain, expect.symptoms = expect.symptoms, []
    for name, factor in (("η²", n**2), ("1/η²", n**-2)):
        expect.symptom(mirrored + (1 - mirrored) * factor, f"{BEHIND}: it leaves the second one without a boundary, and radiance keeps the "
                       f"scale of the inside ({name} too much)")
    # The same numbers as those of a mere factor, and more to the point.
    told = [mean for mean, _ in expect.symptoms]
    expect.symptoms += [symptom for symptom in plain if symptom[0] not in told]


def film_between(tau, albedo, n, photons=20_000):
    """Reflectance of a scattering slab at normal incidence that a film of air cuts into two layers of equal thickness."""
    rng = np.random.default_rng(7)
    first = float(truth.fresnel(1.0, n))
    cos, z, weight, lower = -np.ones(photons), np.zeros(photons), np.ones(photons), np.zeros(photons, bool)
    out = 0.0
    while len(z):
        z = z - cos * np.log(1 - rng.random(len(z)))
        while True:
            above, below = z > np.where(lower, -tau / 2, 0), z < np.where(lower, -tau, -tau / 2)
            met = np.flatnonzero(above | below)
            if not len(met):
                break
            sin2 = (1 - cos[met] ** 2) * n * n
            f = np.where(sin2 >= 1, 1.0, truth.fresnel(np.sqrt(np.maximum(1e-18, 1 - sin2)), n))
            inner = above[met] == lower[met]
            passed = rng.random(len(met)) >= np.where(inner, 2 * f / (1 + f), f)
            out += weight[met[passed & ~inner & above[met]]].sum()
            lower[met[passed & inner]] ^= True
            stay = met[~passed]
            z[stay] = 2 * np.where(above[stay], np.where(lower[stay], -tau / 2, 0), np.where(lower[stay], -tau, -tau / 2)) - z[stay]
            cos[stay] = -cos[stay]
            keep = np.ones(len(z), bool)
            keep[met[passed & ~inner]] = False
            z, cos, weight, lower = z[keep], cos[keep], weight[keep], lower[keep]
        weight = weight * albedo
        lives = (weight >= 0.05) | (rng.random(len(weight)) < 0.5)
        z, lower = z[lives], lower[lives]
        weight = np.where(weight < 0.05, 2 * weight, weight)[lives]
        cos = 2 * rng.random(len(z)) - 1
    return out / photons * (1 - first) + first


def pieces():
    """Blocks in pieces that share faces."""
    d, n = THICKNESS, 1.5
    f = float(truth.fresnel(0.6, n))
    case, expect = furnace("touching-clear", "Clear block in two pieces", ["bodies that touch", "Fresnel"],
                           "A clear cube of index 1.5, cut in two halves that are bodies of their own, seen at a cosine of 0.6 in a uniform environment of "
                           "radiance 1. " + NO_GAPS + " It cannot be seen.", f, n)
    for name, low, high in (("upper half", -d, 0), ("lower half", -2 * d, -d)):
        case.document.add(box((-d, low, -d), (d, high, d)), medium(ior=n), name)
    case.document.camera(OBLIQUE, 0.3 * d, distance=0.5)
    behind(expect, f, n)
    yield case

    f = float(truth.fresnel(1.0, n))
    case = stage(Case("touching-glass", "Reflectance of a clear slab in two pieces", ["bodies that touch", "Fresnel"],
                      "A clear slab of index 1.5 in two layers, over a black plate: it reflects as one slab does, 2F/(1 + F). " + NO_GAPS, spp=1536), "R")
    for name, top in (("upper layer", 0.0), ("lower layer", -d / 2)):
        case.document.add(slab(d / 2, HALF_WIDTH, top), medium(ior=n), name)
    expect = case.expect("the layers", [2 * f / (1 + f)] * 3, CLOSED, ROUNDING, WHY)
    expect.symptom([4 * f / (1 + 3 * f)] * 3, FILM)
    expect.symptom([3 * f / (1 + 2 * f)] * 3, "one of the two boundaries of the shared face reflects")
    expect.symptom([f] * 3, BEHIND + ", so nothing is reflected below it")
    expect.symptom([0] * 3, "the boundary does not reflect")
    yield case

    upper, lower, cos = np.array([0.1, 0.3, 0.6]), np.array([0.8, 0.3, 0.1]), 0.6
    case = stage(Case("touching-absorbing", "Absorbing block in ten pieces", ["bodies that touch", "absorption"],
                      "A block of index 1 in two layers of different absorption, each in five columns; a ray at a cosine of 0.6 passes several of the "
                      "ten pieces, and all their faces are shared. e^(−σa l) with the ways in both layers.", spp=256), "both", cos=cos)
    edges = [-1.0, 0.25 * d, 0.5 * d, 0.75 * d, d, 1.0]
    for layer, tau, top in (("upper", upper, 0.0), ("lower", lower, -d / 2)):
        for k, (left, right) in enumerate(zip(edges, edges[1:])):
            case.document.add(box((left, top - d / 2, -HALF_WIDTH), (right, top, HALF_WIDTH)), medium(2 * tau / d, ior=1), f"{layer}, {k + 1}")
    expect = case.expect("the block", np.exp(-(upper + lower) / cos), BEER, ROUNDING, WHY)
    expect.symptom(np.exp(-upper / cos), "the medium of the second layer is ignored: light that leaves a piece is in air")
    expect.symptom(np.exp(-2 * upper / cos), BEHIND)
    expect.symptom(np.exp(-2 * lower / cos), "the medium of the second layer fills the first one, too")
    expect.symptom(np.exp(-(2 * upper + lower) / cos), "the first layer is not left: in the second both media are added up")
    expect.symptom([1, 1, 1], "absorption is ignored: the pieces are not entered")
    expect.symptom([0, 0, 0], "a piece is entered and never left: light absorbs behind the block, too")
    yield case

    def halves(case, mesh, a, s, expect):
        for name, top in (("upper half", 0.0), ("lower half", -d / 2)):
            case.document.add(slab(d / 2, HALF_WIDTH, top), medium(a, s, G, IOR), name)
        half = [truth.simulate(TAU / 2, x, G, IOR)[0] for x in ALBEDO]
        expect.symptoms = [(m, t) for m, t in expect.symptoms if not t.startswith("coefficients are half")]
        expect.symptom(half, "the medium of the second piece is ignored")
        expect.symptoms.insert(0, expect.symptoms.pop())
        expect.symptom([film_between(TAU, x, IOR) for x in ALBEDO], FILM)
        expect.symptoms.insert(0, expect.symptoms.pop())

    yield sibling("touching-scattering", "Scattering slab in two pieces", "The slab is cut in two layers, each a body of its own with the same medium. "
                  "Light scatters back and forth through the face that they share. " + NO_GAPS, ["bodies that touch", "mesh"], build=halves)


def tumbler(sides, scale):
    """A glass with a thick bottom, and the drink that fills it exactly: walls a tenth of the height, filled to two thirds."""
    wall = [(0.0, -0.5), (0.4, -0.5), (0.4, 0.5), (0.3, 0.5), (0.3, -0.4), (0.0, -0.4)]
    inside = [(0.0, -0.4), (0.3, -0.4), (0.3, 0.2), (0.0, 0.2)]
    scaled = lambda profile: [(scale * r, scale * y) for r, y in profile]
    return revolved(scaled(wall), sides), revolved(scaled(inside), sides)


def drinks():
    """A drink that fills its glass without a gap and without an overlap."""
    text = ("A tumbler of index 1.5 and a drink of index 1.33 in it. The drink's surface is the inner surface of the glass, vertex by vertex: "
            "one boundary of relative index 1.5/1.33, and the drink ends where the glass begins. {how}")
    height, inner, outer = 0.08, 1.33, 1.5
    glass, drink = tumbler(24, height)
    own, bottom = np.array([0.2, 0.7, 1.5]), np.array([0.9, 0.3, 0.1])
    case = Case("drink", "A drink that fills its glass", ["bodies that touch", "absorption", "Fresnel"],
                text.format(how="Both absorb. The camera looks straight down through drink and bottom, where light goes up and down only: a pile of layers."),
                spp=512).under(1)
    depth, base = 0.6 * height, 0.1 * height
    case.document.add(glass, medium(bottom / base, ior=outer), "glass")
    case.document.add(drink, medium(own / depth, ior=inner), "drink")
    case.document.camera(DOWN, 0.1 * height, distance=0.5)
    face = lambda n: (float(truth.fresnel(1.0, n)), 1 - float(truth.fresnel(1.0, n)))
    top, between, below = face(inner), face(outer / inner), face(outer)

    def seen(drink, glass, *middle):
        return [sum(truth.pile([top, (0.0, np.exp(-x)), *middle, (0.0, np.exp(-y)), below])) for x, y in zip(drink, glass)]

    expect = case.expect("drink and bottom", seen(own, bottom, between), CLOSED, ROUNDING, "rounding, with a margin for single precision.")
    expect.symptom(seen(own, bottom, face(inner), face(outer)), "a film of air is between drink and glass")
    expect.symptom(seen(own, bottom, below), "the shared boundary refracts as if air were on one side of it")
    expect.symptom(seen(own, 0 * bottom, between), "the medium of the glass is ignored below the drink")
    expect.symptom(seen(0 * own, bottom, between), "the medium of the drink is ignored")
    expect.symptom(seen(own, bottom + own * base / depth, between), "the drink is not left: in the glass both media are added up")
    expect.symptom(seen(own, own * base / depth), "both boundaries of the shared face are skipped, and the drink's medium goes on in the glass")
    expect.symptom([top[0]] * 3, "both boundaries of the shared face are skipped, and light stays in the drink's medium for ever")
    yield case

    f = float(truth.fresnel(0.8, outer))
    case, expect = furnace("drink-clear", "A clear drink that fills its glass", ["bodies that touch", "Fresnel"],
                           text.format(how="Neither absorbs, so in a uniform environment of radiance 1 they cannot be seen. The camera looks through the wall, "
                                           "across the rim of the drink, at a cosine of 0.8."), f, outer)
    case.document.add(glass, medium(ior=outer), "glass")
    case.document.add(drink, medium(ior=inner), "drink")
    # The ray through the middle of the picture meets the wall at the height of the drink's surface.
    case.document.camera((0, -0.6, -0.8), 0.08 * height, (0, 0.2 * height, 0.4 * height), distance=0.5)
    behind(expect, f, outer)
    yield case


def equals():
    """Two bodies in the same place."""
    d = THICKNESS
    former, later = np.array([0.2, 0.5, 1.0]), np.array([1.2, 0.1, 0.4])
    for name, title, priority, right, wrong, text, symptom in (
        ("equal-later", "Two bodies in one place: the later one", None, later, former,
         "Neither says a priority and both are equally large, so the one whose node comes later in a depth-first traversal of the scene fills the "
         "place. The former lies deeper in the hierarchy, and its node and mesh have the higher indices.",
         "the former body fills the place: bodies are ordered by index, or breadth first, or the first one that is met wins"),
        ("equal-priority", "Two bodies in one place: the higher priority", 1, former, later,
         "The former has priority 1 and fills the place, whatever the order. The later is described in another way, by a mesh of half the size in "
         "a node that is turned over and scaled, so that the surfaces are equal up to rounding only.",
         "the later body fills the place: its priority is not looked at where surfaces coincide"),
    ):
        case = stage(Case(name, title, ["bodies in one place", "priority", "absorption"],
                          "Two absorbing slabs of index 1 are in exactly the same place. " + text, spp=256), "both")
        own = {} if priority is None else {"priority": priority}
        document = case.document
        turned = {} if priority is None else {"scale": [2, 2, 2], "rotation": [1, 0, 0, 0], "translation": [0, -d, 0]}
        mesh = slab(d, HALF_WIDTH) if priority is None else slab(d / 2, HALF_WIDTH / 2)
        document.add(mesh, medium(later / d, ior=1), "later", **turned)
        document.add(slab(d, HALF_WIDTH), medium(former / d, ior=1, **own), "former")
        # The former is the child of a group that is the first of both.
        nodes, roots = document.json["nodes"], document.json["scenes"][0]["nodes"]
        child, last = roots.pop(), roots.pop()
        nodes.append({"name": "group", "children": [child]})
        roots += [len(nodes) - 1, last]
        expect = case.expect("the slabs", np.exp(-right), BEER, ROUNDING, WHY)
        expect.symptom(np.exp(-wrong), symptom)
        expect.symptom(np.exp(-(right + wrong)), "both media are added up")
        expect.symptom([1, 1, 1], "neither fills the place")
        expect.symptom(np.exp(-(right + wrong) / 2), "the one or the other fills the place, by chance")
        expect.symptom([0, 0, 0], "one of the bodies is entered and not left")
        case.others = NO_PRIORITIES
        yield case


def flipped():
    """Parts whose triangles face the other way than those of the rest."""
    d = THICKNESS
    inside = "A medium is inside its mesh whichever way the triangles of a part face."
    tau = np.array([0.2, 0.7, 1.5])
    case = stage(Case("flipped-touching", "Two touching parts, one inside out", ["mesh", "bodies that touch", "absorption"],
                      "One mesh of two layers that share a face; the triangles of the lower one are wound the other way, so that those of the shared face are "
                      "there twice. " + inside + " Index 1: e^(−σa d).", spp=256), "both")
    case.document.add(joined(slab(d / 2, HALF_WIDTH), inside_out(slab(d / 2, HALF_WIDTH, -d / 2))), medium(tau / d, ior=1), "layers")
    expect = case.expect("the layers", np.exp(-tau), BEER, ROUNDING, WHY)
    expect.symptom(np.exp(-tau / 2), "the part that is inside out is taken for air: for a cavity, or for the outside")
    expect.symptom(np.exp(-1.5 * tau), "the part that is inside out counts twice")
    expect.symptom([1, 1, 1], "the part that is inside out cancels the other one: volumes or ways are added up with signs")
    expect.symptom([0, 0, 0], "the medium is thought to be outside, and light absorbs for ever")
    yield case

    case = stage(Case("flipped-crossing", "Two crossing parts, one inside out", ["mesh", "absorption"],
                      "One mesh of two parts that overlap, one two centimetres thick and one three, by one; the lower one is wound the other way. "
                      "Each part is turned right by itself, and together they fill their union. Only a part that lies *inside* another one can be a "
                      "cavity. Index 1: e^(−σa l) with four centimetres.", spp=256), "both", thickness=4 * d)
    case.document.add(joined(slab(2 * d, HALF_WIDTH), inside_out(slab(3 * d, 0.9 * HALF_WIDTH, -d))), medium(tau / (4 * d), ior=1), "parts")
    expect = case.expect("both parts", np.exp(-tau), BEER, ROUNDING, WHY)
    for ways, says in ((3, "the overlap is taken for a cavity: winding numbers of the file cancel there"), (2, "the part that is inside out is not there"),
                       (1, "the part that is inside out is cut away from the other one"), (5, "the overlap counts twice")):
        expect.symptom(np.exp(-tau * ways / 4), says)
    expect.symptom([0, 0, 0], "the medium is thought to be outside, and light absorbs for ever")
    yield case

    n, f = 1.5, float(truth.fresnel(0.6, 1.5))
    case, expect = furnace("flipped-clear", "Clear parts, some inside out", ["mesh", "bodies that touch", "Fresnel"],
                           "One clear mesh of index 1.5 of three cubes: the second reaches into the first and is wound the other way, the third touches the second. "
                           "Seen at a cosine of 0.6 in a uniform environment of radiance 1: it cannot be seen.", f, n)
    cube = lambda x, y: box((x - d, y - 2 * d, -d), (x + d, y, d))
    case.document.add(joined(cube(0, 0), inside_out(cube(0.5 * d, -1.5 * d)), cube(0.5 * d, -3.5 * d)), medium(ior=n), "cubes")
    case.document.camera(OBLIQUE, 0.3 * d, distance=0.5)
    behind(expect, f, n)
    yield case

    outer, inner = np.array([0.2, 0.6, 0.9]), np.array([1.2, 0.1, 0.5])
    case = stage(Case("flipped-nested", "A body inside out within another", ["mesh", "priority", "absorption"],
                      "A plate lies inside a slab three times as thick; both have index 1, and the plate is wound the other way. It is a body of its own, so "
                      "it is no cavity: the smaller one fills its place.", spp=256), "both", thickness=3 * d)
    case.document.add(slab(3 * d, HALF_WIDTH), medium(outer / (3 * d), ior=1), "outer")
    case.document.add(inside_out(slab(d, 0.9 * HALF_WIDTH, -d)), medium(inner / d, ior=1), "inner, inside out")
    expect = case.expect("both", np.exp(-(2 / 3 * outer + inner)), BEER, ROUNDING, WHY)
    expect.symptom(np.exp(-2 / 3 * outer), "the plate is a cavity")
    expect.symptom(np.exp(-outer), "the plate is not there: the outer body fills its place")
    expect.symptom(np.exp(-(outer + inner)), "inside the plate both media absorb")
    expect.symptom([0, 0, 0], "the plate's medium is thought to be outside of it, and light absorbs for ever")
    yield case
