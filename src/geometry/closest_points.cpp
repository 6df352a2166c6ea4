#include "clothsim/geometry/closest_points.h"

#include <algorithm>

namespace clothsim {
namespace {

/// Share from 0 to 1 of the way a -> b at its point closest to p.
double closest_on_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 d = b - a;
  const double length2 = d.squaredNorm();
  return length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0;
}

/// The closest point of a triangle that is a line, by its edges.
std::array<double, 3> closest_on_edges(const Vector3& p, const std::array<Vector3, 3>& corners) {
  std::array<double, 3> best{1, 0, 0};
  double least = (p - corners[0]).squaredNorm();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double s = closest_on_segment(p, corners[i], corners[j]);
    const double distance2 = (p - corners[i] - s * (corners[j] - corners[i])).squaredNorm();
    if (distance2 >= least) continue;
    least = distance2;
    best = {0, 0, 0};
    best[i] = 1 - s;
    best[j] = s;
  }
  return best;
}

}  // namespace

std::array<double, 3> closest_on_triangle(const Vector3& p, const Vector3& a, const Vector3& b,
                                          const Vector3& c) {
  const Vector3 ab = b - a, ac = c - a;
  const double area2 = ab.cross(ac).squaredNorm();
  if (area2 <= parallel * ab.squaredNorm() * ac.squaredNorm())
    return closest_on_edges(p, {a, b, c});

  // Beyond a corner?
  const Vector3 ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};

  // Beyond an edge?
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double s = d1 / (d1 - d3);
    return {1 - s, s, 0};
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double s = d2 / (d2 - d6);
    return {1 - s, 0, s};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double s = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - s, s};
  }

  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

SegmentParameters closest_on_segments(const Vector3& p0, const Vector3& p1, const Vector3& q0,
                                      const Vector3& q1) {
  const Vector3 d1 = p1 - p0, d2 = q1 - q0, r = p0 - q0;
  const double a = d1.squaredNorm(), e = d2.squaredNorm();
  if (a == 0) return {0, closest_on_segment(p0, q0, q1)};
  if (e == 0) return {closest_on_segment(q0, p0, p1), 0};

  const double f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  const double denominator = a * e - b * b;
  double s =
      denominator > parallel * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0;
  double t = (b * s + f) / e;
  if (t < 0) {
    t = 0;
    s = std::clamp(-c / a, 0.0, 1.0);
  } else if (t > 1) {
    t = 1;
    s = std::clamp((b - c) / a, 0.0, 1.0);
  }
  return {s, t};
}

}  // namespace clothsim
