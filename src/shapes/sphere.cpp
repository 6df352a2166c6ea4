#include "clothsim/shapes/sphere.h"

#include "shape_parts.h"

namespace clothsim {

/// A triangle lies within edge / sqrt(3) of its circumcentre.
double Sphere::corner_distance(double edge, double offset) const {
  const double kept = radius + offset;
  return std::sqrt(kept * kept + edge * edge / 3) - radius;
}

std::optional<double> Sphere::entry(const Vector3& from, const Vector3& displacement,
                                    double offset) const {
  const double kept = radius + offset;
  return first_root(displacement.squaredNorm(), from.dot(displacement),
                    from.squaredNorm() - kept * kept);
}

std::optional<FaceDistance> Sphere::face_distance(const Triangle& t, double reach) const {
  const Weights weights = closest_on_triangle(Vector3::Zero(), t[0], t[1], t[2]);
  Closest closest;
  closest.add(Vector3::Zero(), t, weights);
  if (closest.least() > 0) return within(reach, closest.result(), radius);
  const Vector3 n = unit_normal(t);
  return within(reach, {0, n.isZero(0) ? Vector3::UnitZ() : n, weights}, radius);
}

bool Sphere::may_touch(const Box& box, const Triangle*, double reach) const {
  return box.exteriorDistance(Vector3::Zero().eval()) <= radius + reach;
}

}  // namespace clothsim
