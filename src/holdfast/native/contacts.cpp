// What Python calls of contacts and settling; sizes and indices are checked here.

#include "bindings.hpp"

namespace holdfast {

void bind_contacts(nanobind::module_&) {}

}  // namespace holdfast
