// The extension module ``holdfast.native.core``: all that Python calls here.

#include "bindings.hpp"

NB_MODULE(core, m) {
    // After Ctrl-C threads that nobody waits for still hold what they work in when Python ends
    nanobind::set_leak_warnings(false);
    holdfast::bind_elastic(m);
    holdfast::bind_walk(m);
    holdfast::bind_trees(m);
    holdfast::bind_engines(m);
    holdfast::bind_geometry(m);
    holdfast::bind_contacts(m);
    holdfast::bind_settling(m);
    holdfast::bind_drawing(m);
    holdfast::bind_surfaces(m);
}
