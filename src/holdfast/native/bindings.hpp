// What every file of bindings needs: one file for each room, of what Python calls there.

#pragma once

#include "border.hpp"
#include "lock.hpp"

namespace holdfast {

using namespace nanobind::literals;
using nogil = nanobind::call_guard<Unlocked>;  // other threads run while one computes

void bind_elastic(nanobind::module_&);
void bind_walk(nanobind::module_&);
void bind_trees(nanobind::module_&);
void bind_engines(nanobind::module_&);
void bind_geometry(nanobind::module_&);
void bind_contacts(nanobind::module_&);
void bind_settling(nanobind::module_&);
void bind_drawing(nanobind::module_&);
void bind_surfaces(nanobind::module_&);

}  // namespace holdfast
