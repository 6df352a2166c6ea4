#include "clothsim/geometry/rays.h"

#include <algorithm>
#include <cmath>

namespace clothsim {

double hit_by_ray(const Vector3& o, const Vector3& d, const std::array<Vector3, 3>& t) {
  const Vector3 e = t[1] - t[0], f = t[2] - t[0], across = d.cross(f);
  const double det = e.dot(across);
  if (det == 0) return infinity;
  const Vector3 from = o - t[0], up = from.cross(e);
  const double u = from.dot(across) / det, v = d.dot(up) / det, far = f.dot(up) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && far > 0 ? far : infinity;
}

double hit_by_ray(const Vector3& o, const Vector3& d, const Box& box) {
  double in = 0, out = infinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.min()[axis] - o[axis]) / d[axis];
    const double b = (box.max()[axis] - o[axis]) / d[axis];
    if (std::isnan(a) || std::isnan(b)) continue;  // the ray runs along a face
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  return in <= out ? in : infinity;
}

}  // namespace clothsim
