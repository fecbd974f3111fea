// What the nodes of a sheet press and rub under its twist: the contact law (law.hpp), node by node.

#pragma once

#include "span.hpp"

namespace holdfast {

// The nodes of all sheets, as ``Elastic`` has them, and their runs, as ``Runs`` has them
struct Pressing {
    const double *x, *y, *k, *apart;
    const Int* node;
    const double* box;
    Int box_width;
};

// The most that a node of a run with this ``box`` (5,) can be pressed under the sheet's twist ``v`` (6,).
//
// It is rounded as what a node is pressed, and rounding keeps the order: where it is not positive, no node presses.
inline double nearest(const double* box, const double* v, double weight) {
    const double x = v[5] > 0 ? box[1] : box[0], y = v[4] > 0 ? box[2] : box[3];
    return x * v[5] - y * v[4] - v[0] - weight * box[4];
}

// The wrench ``F`` (6,) under a sheet's twist ``v`` (6,) of the runs ``first`` to ``stop`` - 1, and ``D`` (6, 6), whose
// rows are ``width`` numbers apart: minus its derivative.
//
// Returns a number that tells which nodes are open, stuck or sliding.
Int press(const Pressing& nodes, Int first, Int stop, const double* v, double weight, double mu, double rho, double* F,
          double* D, Int width);

}  // namespace holdfast
