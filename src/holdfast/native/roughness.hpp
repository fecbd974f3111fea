// The scatter of the vertices of a surface about smooth surfaces fitted to their neighbourhoods.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr Int LEAST_AROUND = 10, MOST_AROUND = 60;  // vertices in two rings, to which a quadric of 6 terms is fitted
constexpr double SMOOTHNESS =
    0.9659258262890683;  // cosine of 15 deg: the most to the mean normal of an even neighbourhood
constexpr int TERMS = 6;
constexpr double LITTLE = 0.01;  // share of a squared length whose rounding counts

// The directions (3, 3, in rows) along which points are spread, the least first: those of their ``moments`` by Jacobi's
// method
inline std::array<std::array<double, 3>, 3> spread_axes(std::array<std::array<double, 3>, 3> moments) {
    std::array<std::array<double, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // columns, until the end
    for (int sweep = 0; sweep < 30; ++sweep) {
        const double off = std::abs(moments[0][1]) + std::abs(moments[0][2]) + std::abs(moments[1][2]);
        if (!(off > 1e-17 * (moments[0][0] + moments[1][1] + moments[2][2]))) break;
        for (auto [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
            if (moments[p][q] == 0) continue;
            const double half = (moments[q][q] - moments[p][p]) / (2 * moments[p][q]);
            const double tangent = (half >= 0 ? 1.0 : -1.0) / (std::abs(half) + std::sqrt(half * half + 1));
            const double c = 1 / std::sqrt(tangent * tangent + 1), s = tangent * c;
            for (int k = 0; k < 3; ++k) {
                const double a = moments[k][p], b = moments[k][q];
                moments[k][p] = c * a - s * b;
                moments[k][q] = s * a + c * b;
            }
            for (int k = 0; k < 3; ++k) {
                const double a = moments[p][k], b = moments[q][k];
                moments[p][k] = c * a - s * b;
                moments[q][k] = s * a + c * b;
                const double u = axes[k][p], v = axes[k][q];
                axes[k][p] = c * u - s * v;
                axes[k][q] = s * u + c * v;
            }
        }
    }
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return moments[a][a] < moments[b][b]; });
    std::array<std::array<double, 3>, 3> found{};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) found[i][k] = axes[k][order[i]];
    }
    return found;
}

// The standard deviation of some ``vertices`` about the quadric that fits them best
inline double scatter_about(InMat vertices, const std::vector<Int>& around) {
    const auto count = static_cast<Int>(around.size());
    std::array<double, 3> mean{};
    for (Int v : around) {
        for (int k = 0; k < 3; ++k) mean[k] += vertices(v, k) / static_cast<double>(count);
    }
    double scale = 1e-300;
    std::array<std::array<double, 3>, 3> moments{};
    for (Int v : around) {
        double square = 0;
        for (int i = 0; i < 3; ++i) {
            const double arm = vertices(v, i) - mean[i];
            square += arm * arm;
            for (int k = 0; k < 3; ++k) moments[i][k] += arm * (vertices(v, k) - mean[k]);
        }
        scale = std::max(scale, std::sqrt(square));
    }
    const auto axes = spread_axes(moments);
    std::array<std::array<double, MOST_AROUND>, TERMS + 1> column{};  // 1, x, y, x², xy, y², and z
    for (Int i = 0; i < count; ++i) {
        std::array<double, 3> seen{};  // z, y, x
        for (int a = 0; a < 3; ++a) {
            for (int k = 0; k < 3; ++k) seen[a] += axes[a][k] * (vertices(around[i], k) - mean[k]);
            seen[a] /= scale;
        }
        const auto [z, y, x] = seen;
        const double row[] = {1, x, y, x * x, x * y, y * y, z};
        for (int t = 0; t <= TERMS; ++t) column[t][i] = row[t];
    }
    const Int padded = (count + 3) / 4 * 4;  // beyond, all columns are 0
    const auto product = [&](int a, int b) {
        double sum[4] = {0, 0, 0, 0};  // as one sum, each addition would wait for the one before
        for (Int i = 0; i < padded; i += 4) {
            for (int k = 0; k < 4; ++k) sum[k] += column[a][i + k] * column[b][i + k];
        }
        return (sum[0] + sum[1]) + (sum[2] + sum[3]);
    };
    // Gram and Schmidt, twice for a column of which little is left; one that those before it explain is left out
    for (int t = 0; t <= TERMS; ++t) {
        const double before = product(t, t);
        double left = before;
        for (int again = 0; again < 2 && (again == 0 || left < LITTLE * before); ++again) {
            for (int s = 0; s < t; ++s) {
                const double share = product(s, t);
                for (Int i = 0; i < padded; ++i) column[t][i] -= share * column[s][i];
            }
            left = product(t, t);
        }
        if (t == TERMS) break;
        const double by = left > 1e-26 * before ? 1 / std::sqrt(left) : 0.0;
        for (Int i = 0; i < padded; ++i) column[t][i] *= by;
    }
    return scale * std::sqrt(product(TERMS, TERMS) / static_cast<double>(count - TERMS));
}

// The median of some numbers; not a number if one of them is not, or if there are none
inline double median(std::vector<double>& numbers) {
    if (numbers.empty() || std::ranges::any_of(numbers, [](double each) { return std::isnan(each); })) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    const auto middle = numbers.begin() + std::ssize(numbers) / 2;
    std::nth_element(numbers.begin(), middle, numbers.end());
    return numbers.size() % 2 == 1 ? *middle : (*middle + *std::max_element(numbers.begin(), middle)) / 2;
}

// The median length of edges with these ``ends`` (E, 2)
inline double median_length(InMat vertices, InIntMat ends) {
    std::vector<double> lengths;
    lengths.reserve(static_cast<std::size_t>(ends.size()));
    for (Int i = 0; i < ends.size(); ++i) {
        double square = 0;
        for (int k = 0; k < 3; ++k) {
            const double run = vertices(ends(i, 1), k) - vertices(ends(i, 0), k);
            square += run * run;
        }
        lengths.push_back(std::sqrt(square));
    }
    return median(lengths);
}

// The median scatter at up to ``samples`` vertices, evenly among all, whose two rings of neighbours are even: without
// sharp edges. Not a number if there are fewer than ``least_samples`` of them.
inline double median_scatter(InMat vertices, InIntMat faces, In areas, InMat normals, InInts starts, InInts neighbours,
                             Int samples, Int least_samples) {
    Array<double, 2> mean({vertices.size(), 3});
    const auto into = mean.view();
    for (Int f = 0; f < faces.size(); ++f) {
        for (Int corner = 0; corner < 3; ++corner) {
            for (int k = 0; k < 3; ++k) into(faces(f, corner), k) += normals(f, k) * areas[f];
        }
    }
    for (Int v = 0; v < vertices.size(); ++v) {
        const auto n = into[v];
        const double length = std::max(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), 1e-300);
        for (int k = 0; k < 3; ++k) n[k] /= length;
    }
    std::vector<double> found;
    std::vector<Int> around;
    const Int last = vertices.size() - 1;
    const double step = static_cast<double>(last) / static_cast<double>(samples - 1);
    for (Int sample = 0, before = -1; sample < samples; ++sample) {
        const Int vertex = sample + 1 < samples ? static_cast<Int>(static_cast<double>(sample) * step) : last;
        if (std::exchange(before, vertex) == vertex) continue;
        const auto ring = neighbours.part(starts[vertex], starts[vertex + 1]);
        around.assign(ring.begin(), ring.end());
        for (Int one : ring) {
            const auto more = neighbours.part(starts[one], starts[one + 1]);
            around.insert(around.end(), more.begin(), more.end());
        }
        std::sort(around.begin(), around.end());
        around.erase(std::unique(around.begin(), around.end()), around.end());
        const auto count = static_cast<Int>(around.size());
        if (count < LEAST_AROUND || count > MOST_AROUND) continue;
        std::array<double, 3> middle{};
        for (Int v : around) {
            for (int k = 0; k < 3; ++k) middle[k] += into(v, k) / static_cast<double>(count);
        }
        const double length = std::sqrt(middle[0] * middle[0] + middle[1] * middle[1] + middle[2] * middle[2]);
        double least = std::numeric_limits<double>::infinity();
        for (Int v : around) {
            least = std::min(least, into(v, 0) * middle[0] + into(v, 1) * middle[1] + into(v, 2) * middle[2]);
        }
        if (least >= SMOOTHNESS * length) found.push_back(scatter_about(vertices, around));
    }
    return std::ssize(found) < least_samples ? std::numeric_limits<double>::quiet_NaN() : median(found);
}

}  // namespace holdfast
