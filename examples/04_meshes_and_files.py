"""
4. Bodies from meshes, friction by material, a scene file to keep
=================================================================

Everything in one round trip.
"""

import sys
from pathlib import Path

import trimesh

import holdfast as hf

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(exist_ok=True)
trimesh.creation.annulus(r_min=0.03, r_max=0.04, height=0.12, sections=48).export(folder / "vase.stl")

scene = hf.Scene(
    bodies=[
        hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), position=(0, 0, -0.01), material="oak", fixed=True),
        hf.Body("vase", hf.Mesh.from_file(folder / "vase.stl"), density=2500, position=(0, 0, 0.06), material="glass"),
        hf.Body("candle", hf.Cylinder(0.02, 0.08), mass=0.1, position=(0.1, 0, 0.04)),
    ],
    friction=hf.Friction(default=0.5, pairs={("oak", "glass"): 0.35}),
    name="shelf",
)
hf.save_scene(scene, folder / "shelf.yaml")
assembly = hf.assemble(hf.load_scene(folder / "shelf.yaml"))
for interface in assembly.interfaces:
    a, b = interface.bodies
    print(f"{a} - {b}: {interface.area * 1e4:.2f} cm², μ {assembly.scene.mu(a, b)}")
print("weakest:", hf.robustness_map(assembly).weakest())
