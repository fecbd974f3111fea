"""
A pallet
========

Cartons on a pallet: is one crushed, how fast may the lorry brake, and what does a strap change?
"""

# %%
# Two cartons side by side and a long one across them, which slides more easily. A carton bears 250 N on top.
import holdfast as hf

# sphinx_gallery_thumbnail_path = 'images/pack.png'


def carton(name: str, size: tuple[float, float, float], mass: float, x: float, z: float) -> hf.Body:
    return hf.Body(name, hf.Box(size), mass=mass, position=(x, 0, z), material="carton", top_load=250.0)


load = hf.assemble(
    hf.Scene(
        [
            hf.Body("deck", hf.Box((2, 2, 0.1)), position=(0, 0, -0.05), fixed=True, material="deck"),
            carton("left", (0.4, 0.6, 0.4), 20, -0.2, 0.2),
            carton("right", (0.4, 0.6, 0.4), 20, 0.2, 0.2),
            carton("top", (0.6, 0.6, 0.3), 12, 0.0, 0.55),
        ],
        hf.Friction(default=0.35, pairs={("carton", "deck"): 0.6}),
        name="pallet",
    )
)
load

# %%
# Who bears how much? The fullest comes first.
for entry in hf.stability(load).bearing:
    print(entry.text)

# %%
# How fast may the lorry brake, accelerate, turn? The distance from the centre is the largest acceleration that way.
limits = hf.transport_limits(load)
limits

# %%
# The accelerations that a load on the road has to withstand are more than that:
ride = hf.carry(load, "road")
print(f"{ride.outcome}: {ride.first} first; it holds at {ride.time_scale(margin=0.1):.2f} times the speed")

# %%
# A strap over the top, drawn tight to 2 kN, holds the load with much to spare. But it would crush the carton beneath
# it: draw it less tight, and lay edge boards under it.
route = [("deck", (0, -0.3, 0)), ("top", (0, -0.3, 0.7)), ("top", (0, 0.3, 0.7)), ("deck", (0, 0.3, 0))]
strap = hf.Strap(route, 2000, mu=0.15)
tied = hf.carry(load, "road", standing=strap.loads(load))
print(f"{tied.outcome}: {tied.reason}")
crushed = hf.stability(load, loads=strap.loads(load)).bearing[0]
print(crushed.text)
