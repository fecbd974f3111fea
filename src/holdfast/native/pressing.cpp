// What the nodes of a sheet press and rub. Many sums are carried along at once, for which processors with more
// registers take less time.

#include "pressing.hpp"

#include <cmath>

#include "wide.hpp"

namespace holdfast {

HOLDFAST_WIDE
Int press(const Pressing& n, Int first, Int stop, const double* v, double weight, double mu, double rho, double* F,
          double* D, Int width) {
    const double *xs = n.x, *ys = n.y, *ks = n.k, *gaps = n.apart;
    const Int* begins = n.node;
    const double v0 = v[0], v1 = v[1], v2 = v[2], v3 = v[3], v4 = v[4], v5 = v[5];
    const double slippery = (mu / rho) * (mu / rho);
    Int states = 0;
    double fn = 0.0, f1 = 0.0, f2 = 0.0, gn = 0.0, g1 = 0.0, g2 = 0.0;
    double nn = 0.0, ny = 0.0, nx = 0.0, nyy = 0.0, nxy = 0.0, nxx = 0.0;  // normal by normal
    double sk = 0.0, sx = 0.0, sy = 0.0, sr = 0.0;  // of nodes that stick: Σ k, Σ k x, Σ k y and Σ k (x² + y²)
    // Tangential by tangential, of nodes that slide
    double t11 = 0.0, t12 = 0.0, t1w = 0.0, t22 = 0.0, t2w = 0.0, tww = 0.0;
    // Tangential by normal
    double c1 = 0.0, c1y = 0.0, c1x = 0.0, c2 = 0.0, c2y = 0.0, c2x = 0.0, cw = 0.0, cwy = 0.0, cwx = 0.0;
    for (Int run = first; run < stop; ++run) {
        if (nearest(n.box + run * n.box_width, v, weight) <= 0.0) continue;
        for (Int i = begins[run]; i < begins[run + 1]; ++i) {
            const double x = xs[i], y = ys[i], k = ks[i];
            const double pressed = x * v5 - y * v4 - v0 - weight * gaps[i];
            if (pressed <= 0.0) continue;
            const double kx = k * x, ky = k * y, kxx = kx * x, kyy = ky * y;
            nn += k;
            ny += ky;
            nx -= kx;
            nyy += kyy;
            nxy -= ky * x;
            nxx += kxx;
            const double normal = k * pressed;
            fn += normal;
            g1 += y * normal;
            g2 -= x * normal;
            if (mu <= 0.0) continue;  // no friction: nothing sticks, not even where nothing has moved yet
            const double u1 = v1 - y * v3, u2 = v2 + x * v3, square = u1 * u1 + u2 * u2;
            if (square <= slippery * pressed * pressed) {
                sk += k;
                sx += kx;
                sy += ky;
                sr += kxx + kyy;
                states += i + 1;
                continue;
            }
            const double inverse = 1 / std::sqrt(square), e1 = u1 * inverse, e2 = u2 * inverse;
            const double s1 = -mu * normal * e1, s2 = -mu * normal * e2, h = mu * normal * inverse;
            const double d11 = h * e2 * e2, d12 = -h * e1 * e2, d22 = h * e1 * e1;
            t11 += d11;
            t12 += d12;
            t1w += x * d12 - y * d11;
            t22 += d22;
            t2w += x * d22 - y * d12;
            tww += y * y * d11 - 2 * x * y * d12 + x * x * d22;
            const double b1 = -mu * k * e1, b2 = -mu * k * e2;  // less friction where the contact lifts
            const double bw = x * b2 - y * b1;
            c1 += b1;
            c1y += b1 * y;
            c1x -= b1 * x;
            c2 += b2;
            c2y += b2 * y;
            c2x -= b2 * x;
            cw += bw;
            cwy += bw * y;
            cwx -= bw * x;
            states += (i + 1) * 7919;
            f1 += s1;
            f2 += s2;
            gn += x * s2 - y * s1;
        }
    }
    f1 -= rho * (sk * v1 - sy * v3);
    f2 -= rho * (sk * v2 + sx * v3);
    gn -= rho * (sx * v2 - sy * v1 + sr * v3);
    t11 += rho * sk;
    t1w -= rho * sy;
    t22 += rho * sk;
    t2w += rho * sx;
    tww += rho * sr;
    const auto write = [](double* into, double one, double two, double three, double four, double five, double six) {
        into[0] = one;
        into[1] = two;
        into[2] = three;
        into[3] = four;
        into[4] = five;
        into[5] = six;
    };
    write(F, fn, f1, f2, gn, g1, g2);
    write(D, nn, 0.0, 0.0, 0.0, ny, nx);
    write(D + width, c1, t11, t12, t1w, c1y, c1x);
    write(D + 2 * width, c2, t12, t22, t2w, c2y, c2x);
    write(D + 3 * width, cw, t1w, t2w, tww, cwy, cwx);
    write(D + 4 * width, ny, 0.0, 0.0, 0.0, nyy, nxy);
    write(D + 5 * width, nx, 0.0, 0.0, 0.0, nxy, nxx);
    return states;
}

}  // namespace holdfast
