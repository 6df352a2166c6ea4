#include "clothsim/geometry/distances.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Of directions, see closest_points.cpp; and of lengths squared, so that nothing is divided by 0.
constexpr double parallel = 1e-14;
constexpr double tiny = 1e-300;

/// Of lengths squared: more than rounding adds to a distance squared.
constexpr double rounding = 1e-14;

struct Coordinates {
  const double* x;
  const double* y;
  const double* z;
};

struct Indices {
  const int* a;
  const int* b;
  const int* c;
  const int* d;
};

// Ternaries instead of std::min, std::max and std::clamp: these return references, which keep the
// compiler from vectorising.
inline double smaller(double a, double b) { return a < b ? a : b; }
inline double larger(double a, double b) { return a > b ? a : b; }
inline double to_unit(double t) { return smaller(larger(t, 0.0), 1.0); }

/// Of points a to triangles b, c, d: the least to its edges, or to its plane where that is within.
/// All from the products of the ways from b.
CLOTHSIM_TARGET_CLONES
void point_triangle(std::size_t count, const Coordinates p, const Indices i,
                    double* __restrict values, double* __restrict inside) {
  for (std::size_t k = 0; k < count; ++k) {
    const int a = i.a[k], b = i.b[k], c = i.c[k], d = i.d[k];
    const double ux = p.x[c] - p.x[b], uy = p.y[c] - p.y[b], uz = p.z[c] - p.z[b];
    const double vx = p.x[d] - p.x[b], vy = p.y[d] - p.y[b], vz = p.z[d] - p.z[b];
    const double wx = p.x[a] - p.x[b], wy = p.y[a] - p.y[b], wz = p.z[a] - p.z[b];
    const double uu = ux * ux + uy * uy + uz * uz;
    const double vv = vx * vx + vy * vy + vz * vz;
    const double uv = ux * vx + uy * vy + uz * vz;
    const double ww = wx * wx + wy * wy + wz * wz;
    const double uw = ux * wx + uy * wy + uz * wz;
    const double vw = vx * wx + vy * wy + vz * wz;

    // Squares of the distances to b -> c, b -> d and c -> d.
    const double s = to_unit(uw / (uu + tiny));
    const double t = to_unit(vw / (vv + tiny));
    const double ee = uu - 2 * uv + vv, ew = vw - uw - uv + uu;
    const double r = to_unit(ew / (ee + tiny));
    const double on_u = ww - 2 * s * uw + s * s * uu;
    const double on_v = ww - 2 * t * vw + t * t * vv;
    const double on_e = ww - 2 * uw + uu - 2 * r * ew + r * r * ee;
    const double on_edges = smaller(on_u, smaller(on_v, on_e));

    const double area2 = uu * vv - uv * uv;
    const double beta = uw * vv - vw * uv, gamma = vw * uu - uw * uv;  // times area2
    const bool within =
        (beta >= 0) & (gamma >= 0) & (beta + gamma <= area2) & (area2 > parallel * uu * vv);
    const double thinness = uu * vv / (area2 + tiny);
    const double on_plane = ww - (beta * uw + gamma * vw) / (area2 + tiny);
    // In thin triangles the first one's rounding grows, and the edges are the nearer.
    const double on_inside =
        larger(on_plane - rounding * thinness * ww, on_edges - larger(uu, vv) / thinness);
    const double least = (within ? on_inside : on_edges) - rounding * (uu + vv + ww);
    values[k] = std::sqrt(larger(least, 0.0));
    inside[k] = within & (beta > 0) & (gamma > 0) & (beta + gamma < area2) ? 1.0 : 0.0;
  }
}

Coordinates coordinates(const Points& x) {
  return {x.data(), x.data() + x.rows(), x.data() + 2 * x.rows()};
}

template <typename Lists>
Indices indices(const Lists& points) {
  return {points[0].data(), points[1].data(), points[2].data(), points[3].data()};
}

}  // namespace

void Distances::measure(const Points& positions) {
  point_triangle(size_, coordinates(positions), indices(points_), values_.data(), inside_.data());
}

}  // namespace clothsim
