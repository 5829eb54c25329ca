"""All cases of the suite."""
from descriptions import invariances, khronos, layers, looks
from media import absorption, furnaces, glass, scatterings
from scenes import lights, pictures, spheres
from surfaces import sheets, smooth
from touching import drinks, equals, flipped, pieces


def everything():
    for group in (furnaces, absorption, scatterings, glass, invariances, layers, looks, khronos, spheres, lights, pictures,
                  pieces, drinks, equals, flipped, smooth, sheets):
        yield from group()
