// Bounds of γ = 1/R at loads in many directions, from non-negative combinations of loads with known bounds.

#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "small_equations.hpp"
#include "span.hpp"

namespace holdfast {

// Non-negative least squares (Lawson & Hanson) of ``count`` columns of six numbers, and the memory for it
class NonNegative {
  public:
    explicit NonNegative(Int count)
        : count_(count),
          columns_({count, 6}),
          gram_({count, count}),
          small_({count * count}),
          pull_(count),
          x_(count),
          right_(count),
          chosen_(count),
          active_(count) {}

    // Find x >= 0 for which the sum of x times ``columns`` is close to ``target`` (6,). A bound from it holds for any
    // x >= 0, and is tighter the closer the sum comes to the target.
    const std::vector<double>& close_to(const double* target) {
        const Mat gram = gram_.view();
        for (Int a = 0; a < count_; ++a) {
            const double* one = column(a);
            pull_[a] = product(one, target);
            for (Int b = 0; b <= a; ++b) gram(a, b) = gram(b, a) = product(one, column(b));
        }
        std::fill(x_.begin(), x_.end(), 0.0);
        std::fill(active_.begin(), active_.end(), 0);
        for (Int round = 0; round < 3 * count_; ++round) {
            const Int best = steepest();
            if (best < 0) break;
            active_[best] = 1;
            if (!descend_among_active()) break;
        }
        for (double& share : x_) share = std::max(share, 0.0);
        return x_;
    }

    double* column(Int a) { return columns_.numbers.data() + 6 * a; }

  private:
    Int count_;
    Array<double, 2> columns_, gram_;
    Array<double> small_;
    std::vector<double> pull_, x_, right_;
    std::vector<Int> chosen_;
    std::vector<unsigned char> active_;

    static double product(const double* a, const double* b) {
        double sum = 0.0;
        for (int c = 0; c < 6; ++c) sum += a[c] * b[c];
        return sum;
    }

    // The column that is not active along which the distance falls most, -1 if along none
    Int steepest() const {
        Int best = -1;
        double most = 1e-12;
        for (Int a = 0; a < count_; ++a) {
            if (active_[a]) continue;
            const double* row = gram_.numbers.data() + a * count_;
            double sum = 0.0;
            for (Int b = 0; b < count_; ++b) sum += row[b] * x_[b];
            if (pull_[a] - sum > most) {
                best = a;
                most = pull_[a] - sum;
            }
        }
        return best;
    }

    // Go to the least distance over the active columns, those left out on the way that would become negative; false if
    // they do not tell where it is
    bool descend_among_active() {
        for (Int round = 0; round < count_; ++round) {
            Int size = 0;
            for (Int a = 0; a < count_; ++a) {
                if (active_[a]) chosen_[size++] = a;
            }
            const Mat small(small_.numbers.data(), {size, size});
            const Vec z(right_.data(), {size});
            for (Int a = 0; a < size; ++a) {
                z[a] = pull_[chosen_[a]];
                const double* row = gram_.numbers.data() + chosen_[a] * count_;
                for (Int b = 0; b < size; ++b) small(a, b) = row[chosen_[b]];
                small(a, a) *= 1 + 1e-13;
            }
            if (!solve_dense(small, z)) return false;
            double step = 1.0;
            for (Int a = 0; a < size; ++a) {
                const double x = x_[chosen_[a]];
                if (z[a] <= 0.0) step = std::min(step, x > z[a] ? x / (x - z[a]) : 0.0);
            }
            for (Int a = 0; a < size; ++a) x_[chosen_[a]] += step * (z[a] - x_[chosen_[a]]);
            if (step >= 1.0) return true;
            for (Int a = 0; a < size; ++a) {
                if (z[a] <= 0.0 && x_[chosen_[a]] <= 1e-14) {
                    x_[chosen_[a]] = 0.0;
                    active_[chosen_[a]] = 0;
                }
            }
        }
        return true;
    }
};

// Write upper bounds (n,) of γ at the loads ``points`` (n, 6). Each point is written as a non-negative combination of
// the ``known`` loads (m, 6), whose upper bounds are ``values`` (m,). ``near`` (n, k) are the numbers of the known
// loads to combine for each point. The difference between a point and its combination is bounded component by
// component, with the upper bounds ``axes`` (2, 6) of γ along the positive and the negative direction of each axis.
// What rounding may hide in a difference, the share ``rounding`` of its terms, is paid for along both.
inline void combined(InMat points, InMat known, InIntMat near, In values, InMat axes, double rounding, Vec result) {
    const Int count = near.size(1);
    NonNegative search(count);
    for (Int i = 0; i < points.size(); ++i) {
        const auto numbers = near[i];
        for (Int a = 0; a < count; ++a) std::copy_n(known[numbers[a]].data(), 6, search.column(a));
        const auto& share = search.close_to(points[i].data());
        double total = 0.0;
        for (Int a = 0; a < count; ++a) total += share[a] * values[numbers[a]];
        for (int c = 0; c < 6; ++c) {
            double missing = points(i, c), size = std::abs(missing);
            for (Int a = 0; a < count; ++a) {
                const double entry = search.column(a)[c];
                missing -= entry * share[a];
                size += std::abs(entry) * share[a];
            }
            if (missing > 0.0) {
                total += missing * axes(0, c);
            } else if (missing < 0.0) {
                total -= missing * axes(1, c);
            }
            if (size > 0.0) total += rounding * size * (axes(0, c) + axes(1, c));
        }
        result[i] = total * (1.0 + rounding);
    }
}

}  // namespace holdfast
