"""The formats of scene files, one module or package each."""

# All of them: the module in this package, and the name of its ``Format`` there. To add a format, write a module and
# list it here. If several formats recognise a file, the first in this list reads it. They are names, for the registry
# imports them with the first scene file: scenes need not come from files.
FORMATS = (
    ("native", "NATIVE"),
    ("published", "PUBLISHED"),
    ("published", "SETTLED_SCENE"),
    ("mjcf.reader", "MJCF"),
    ("robots.urdf", "URDF"),
    ("robots.sdf", "SDF"),
    ("gltf_scene", "GLTF"),
    ("compas", "COMPAS"),
    ("usd.reader", "USD"),
    ("planning_scenes", "MOVEIT"),
    ("robots.drake", "DRAKE"),
    ("habitat", "HABITAT"),
    ("packing_plan", "PACKING_PLAN"),
    ("ldraw.reader", "LDRAW"),
    ("box_table", "BOX_TABLE"),
    ("named_meshes", "MESH_FILE"),
    ("planning_scenes", "BAG"),
)
