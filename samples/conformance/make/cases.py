"""All cases of the suite."""
from descriptions import invariances, khronos, layers, looks
from media import absorption, furnaces, glass, scatterings
from scenes import lights, pictures, spheres


def everything():
    for group in (furnaces, absorption, scatterings, glass, invariances, layers, looks, khronos, spheres, lights, pictures):
        yield from group()
