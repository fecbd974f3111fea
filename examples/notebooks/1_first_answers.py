"""
First answers
=============

A shelf with a book and a vase: does it stand, how hard may one push, where is it weakest?
"""

# %%
# Describe what there is. Lengths are in metres, masses in kilograms; contacts are found.
import holdfast as hf

# sphinx_gallery_thumbnail_path = 'images/shelf.png'

scene = hf.Scene(
    [
        hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), position=(0, 0, -0.01), fixed=True),
        hf.Body("book", hf.Box((0.15, 0.21, 0.03)), mass=0.7, position=(-0.1, 0, 0.015)),
        hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, position=(0.1, 0, 0.1)),
    ],
    friction=0.5,
    name="shelf",
)
shelf = hf.assemble(scene)
shelf

# %%
# Does it stand? The answer is stable, unstable or undecided, with the reason.
hf.stability(shelf)

# %%
# Push the vase at 15 cm. It topples at weight times radius over height, 0.785 N. Plan with ``lower``, which allows for
# errors of the computation; above ``upper`` something moves for certain.
push = hf.robustness(shelf, "vase", (0.07, 0, 0.15), (1, 0, 0), bounds=True)
print(f"force {push.force[0]:.3f} N, lower {push.lower[0]:.3f} N, upper {push.upper[0]:.3f} N: {push.mode[0]}")

# %%
# The same everywhere: dark red is weak, blue cannot be moved.
pushes = hf.robustness_map(shelf, spacing=0.01)
pushes

# %%
# The weakest spot of all is the rim of the vase.
weak = pushes.weakest()
print(f"{weak.body}: {weak.force:.2f} N, {weak.mode}")

# %%
# Friction is a guess. With anything between 0.2 and 0.6, and masses within a tenth, this is the least push at the foot:
foot = ("vase", (0.07, 0, 0.02), (1, 0, 0))
worst = hf.sets.worst_case(shelf, *foot, mu_range=(0.2, 0.6), mass_range=0.1)
print(f"as given {worst.nominal[0]:.2f} N, at worst it holds {worst.lower[0]:.2f} N")
