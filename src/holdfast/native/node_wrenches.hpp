// The wrenches of forces at contact nodes on the bodies.

#pragma once

#include <algorithm>
#include <vector>

#include "span.hpp"

namespace holdfast {

// Return the wrenches (6J,) [N, N m] about the centres of mass ``com`` (J, 3) of ``forces`` (I, 3) [N] at nodes, along
// the rows of their ``axes`` (I, 3, 3), on bodies ``b`` and their negatives on bodies ``a`` (I,); fixed ones are -1
inline Array<double> node_wrenches(InMat points, InTen axes, InInts a, InInts b, InMat com, InMat forces) {
    const Int count = com.size();
    Array<double> found({6 * count});
    std::vector<double> own(found.numbers.size());
    for (const bool second : {true, false}) {
        std::fill(own.begin(), own.end(), 0.0);
        for (Int i = 0; i < points.size(); ++i) {
            const Int body = second ? b[i] : a[i];
            if (body < 0) continue;
            const In point = points[i], f = forces[i];
            const InMat R = axes[i];
            double force[3], arm[3];
            for (int k = 0; k < 3; ++k) {
                force[k] = f[0] * R(0, k) + f[1] * R(1, k) + f[2] * R(2, k);
                arm[k] = point[k] - com(body, k);
            }
            double* to = own.data() + 6 * body;
            for (int k = 0; k < 3; ++k) to[k] += force[k];
            to[3] += arm[1] * force[2] - arm[2] * force[1];
            to[4] += arm[2] * force[0] - arm[0] * force[2];
            to[5] += arm[0] * force[1] - arm[1] * force[0];
        }
        for (std::size_t i = 0; i < own.size(); ++i) found.numbers[i] += second ? own[i] : -own[i];
    }
    return found;
}

}  // namespace holdfast
