// What Python calls of geometry; sizes and indices are checked here.

#include "bindings.hpp"

namespace holdfast {

void bind_geometry(nanobind::module_&) {}

}  // namespace holdfast
