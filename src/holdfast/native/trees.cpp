// What Python calls of trees; sizes and indices are checked here.

#include "bindings.hpp"

namespace holdfast {

void bind_trees(nanobind::module_&) {}

}  // namespace holdfast
