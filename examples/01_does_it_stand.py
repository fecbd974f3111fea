"""
1. Does it stand, and why?
==========================

Three cubes, then the same with the middle one pushed half way out.
"""

import holdfast as hf


def cube(name: str, x: float, z: float) -> hf.Body:
    return hf.Body(name, hf.Box((0.1, 0.1, 0.1)), mass=1.0, position=(x, 0, z))


ground = hf.Body("ground", hf.Box((1, 1, 0.1)), position=(0, 0, -0.05), fixed=True)

for offset in (0.0, 0.06):
    bodies = [ground, cube("bottom", 0, 0.05), cube("middle", offset, 0.15), cube("top", offset, 0.25)]
    assembly = hf.assemble(hf.Scene(bodies, friction=0.6))
    result = hf.stability(assembly)
    print(f"middle cube {offset * 100:.0f} cm out: {result.status}")
    print(f"  {result.reason}")
    if result.certificate is not None:
        print(f"  certificate: gains {result.certificate.power:.3g} W, violation {result.certificate.violation:.0e}")
