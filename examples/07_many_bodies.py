"""
7. Many bodies
==============

Cuts grow exponentially; the engine refuses in good time and says what can be done.
"""

import holdfast as hf

scene = hf.shipped_scene("bonded_wall")
assembly = hf.assemble(scene)
verdict = hf.stability(assembly, engine="graph")
print(f"{len(assembly.movable)} bodies, {len(assembly.interfaces)} interfaces: {verdict.status}")
try:
    hf.robustness_map(assembly, spacing=0.05, engine="graph")
except hf.errors.SolverError as error:
    print(error)

# One remedy: only the upper three courses may move. Say so where the answer is used: it is optimistic.
bodies = [
    b if b.name == "floor" or int(b.name[1]) >= 7 else hf.Body(b.name, b.shape, pose=b.pose, fixed=True)
    for b in scene.bodies
]
upper = hf.assemble(hf.Scene(bodies, scene.friction, scene.gravity, "upper courses"))
weak = hf.robustness_map(upper, bodies=["b9_4"], spacing=0.02, engine=hf.Graph(max_cuts=50_000)).weakest()
print(f"weakest push on the last brick: {weak.force:.3g} N, {weak.mode} of {', '.join(weak.moving)}")
