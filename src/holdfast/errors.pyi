from holdfast.base.errors import GeometryError as GeometryError
from holdfast.base.errors import HoldfastWarning as HoldfastWarning
from holdfast.base.errors import SceneError as SceneError
from holdfast.base.errors import SolverError as SolverError
from holdfast.base.errors import UnstableError as UnstableError
