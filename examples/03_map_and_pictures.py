"""
3. A map over every exposed surface, with pictures
==================================================

A bottle on an overhanging book is the weak spot.
"""

import sys
from pathlib import Path

import holdfast as hf

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(exist_ok=True)
m = hf.robustness_map(hf.assemble(hf.shipped_scene("tabletop")), spacing=0.015)
for weak in m.weakest_of_each_body():
    print(f"{weak.body:12s} {weak.force:7.3g} N  {weak.mode:6s} moves {', '.join(weak.moving)}")
m.save_png(folder / "tabletop.png")
m.save_html(folder / "tabletop.html")
m.save_glb(folder / "tabletop.glb")  # for three.js, Blender, a game engine; save_ply for MeshLab or CloudCompare
print("pictures in", folder.name)
