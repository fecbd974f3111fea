// The elastic model of an assembly on plain arrays, as ``elastic/model.py`` makes it.

#pragma once

#include <tuple>

#include "span.hpp"

namespace holdfast {

// R runs of a few nodes each, that lie together, of P sheets: where none of them presses, none is looked at.
// Those of sheet p are first[p] to first[p + 1] - 1, and run k has nodes node[k] to node[k + 1] - 1; box (R, 5): their
// least and largest x, least and largest y, and least clearance
struct Runs {
    InInts first, node;
    InMat box;
    static constexpr auto fields = std::tuple{&Runs::first, &Runs::node, &Runs::box};
};

// P sheets of I nodes between J bodies; ``elastic/model.py`` says what each array is
struct Elastic {
    InInts first;
    In x, y, k, apart, mu;
    double rho;
    InInts a, b;
    InTen axes;
    InMat arm_a, arm_b;
    In wrench, scale;
    InTen bonded;
    In unit;
    Runs runs;
    In hold, still;
    static constexpr auto fields =
        std::tuple{&Elastic::first, &Elastic::x,     &Elastic::y,      &Elastic::k,     &Elastic::apart,
                   &Elastic::mu,    &Elastic::rho,   &Elastic::a,      &Elastic::b,     &Elastic::axes,
                   &Elastic::arm_a, &Elastic::arm_b, &Elastic::wrench, &Elastic::scale, &Elastic::bonded,
                   &Elastic::unit,  &Elastic::runs,  &Elastic::hold,   &Elastic::still};
};

// The fronts of a model in the order of elimination; ``elastic/system.py`` says what each array is
struct Fronts {
    InInts first, body, owned, onward, begin, child, since, sheet, at_a, at_b;
    static constexpr auto fields =
        std::tuple{&Fronts::first, &Fronts::body,  &Fronts::owned, &Fronts::onward, &Fronts::begin,
                   &Fronts::child, &Fronts::since, &Fronts::sheet, &Fronts::at_a,   &Fronts::at_b};
};

}  // namespace holdfast
