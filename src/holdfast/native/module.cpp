// The extension module ``holdfast.native.core``: all that Python calls here.

#include "bindings.hpp"

NB_MODULE(core, m) {
    holdfast::bind_elastic(m);
    holdfast::bind_walk(m);
    holdfast::bind_trees(m);
    holdfast::bind_engines(m);
    holdfast::bind_geometry(m);
    holdfast::bind_contacts(m);
    holdfast::bind_drawing(m);
}
