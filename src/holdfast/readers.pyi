from holdfast.scene.formats.planning_scenes import from_planning_scene as from_planning_scene
from holdfast.scene.formats.simulators.genesis_scene import from_genesis as from_genesis
from holdfast.scene.formats.simulators.sapien_scene import from_sapien as from_sapien
