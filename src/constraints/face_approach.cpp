#include "clothsim/constraints/face_approach.h"

#include <algorithm>

#include "clothsim/shapes/swept_face.h"

namespace clothsim {
namespace {

Triangle to_world(const Pose& pose, Triangle t) {
  for (Vector3& p : t) p = pose.position + pose.orientation * p;
  return t;
}

/// May a point have passed through the shape in one step?
bool is_fast(const Shape& shape, const Vector3& displacement) {
  const double depth = safe_depth(shape);
  return displacement.squaredNorm() > depth * depth;
}

double longest_edge(const Triangle& t) {
  return std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
}

}  // namespace

bool is_held_inside(const Cloth& cloth, const Corners& corners, const LocalCloth& local) {
  return std::any_of(corners.begin(), corners.end(), [&](int i) {
    return cloth.inv_mass[i] == 0 && local.distance[i] < -surface_offset;
  });
}

Vector3 raise_of_held(const Shape& shape, double offset, const Triangle& t, std::size_t corner) {
  constexpr double raised_share = 0.01;  // of the longest edge
  const Distance distance = signed_distance(shape, t[corner], t[corner]);
  return std::max(0.0, offset + raised_share * longest_edge(t) - distance.value) * distance.normal;
}

Triangle raised_at_held(const Shape& shape, const Cloth& cloth, const Corners& corners,
                        const Triangle& t) {
  Triangle raised = t;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!cloth.is_held(corners[k])) continue;
    raised[k] += raise_of_held(shape, cloth.offset_at(corners[k]), t, k);
  }
  return raised;
}

double leeway(const Cloth& cloth, const Corners& corners, const Triangle& t,
              const CornerWeights& weights) {
  constexpr double min_lever = 0.25;  // below it contacts may sink in
  constexpr double max_share = 0.1;   // of the longest edge, at a lever of 0
  const double lever = lever_of(cloth, corners, weights);
  if (lever >= min_lever) return 0;
  return max_share * longest_edge(t) * (1 - lever / min_lever);
}

SupportingPlane supporting_plane(const Shape& shape, const Triangle& t,
                                 const std::optional<FaceDistance>& found) {
  constexpr double rounding = 1e-12;  // of the shape's size: it bounds rounded products, too
  if (!is_convex_solid(shape) || (found && found->value <= 0)) return {};
  const auto along = [&](const Vector3& normal) {
    const double farthest = normal.dot(*support(shape, normal));
    return SupportingPlane{normal, farthest + rounding * bounding_radius(shape)};
  };
  if (found) return along(found->normal);
  SupportingPlane farthest;
  for (const Vector3& corner : t) {
    const SupportingPlane plane = along(signed_distance(shape, corner, corner).normal);
    if (plane.distance_of(t) > farthest.distance_of(t)) farthest = plane;
  }
  return farthest;
}

FaceApproach approach(const MovingCollider& collider, const Cloth& cloth, std::size_t triangle,
                      const LocalCloth& local, double margin) {
  const Shape& shape = collider.shape();
  const Corners& corners = cloth.triangles[triangle];
  const FaceQuery query = local.query(triangle, corners);
  const Triangle from = raised_at_held(shape, cloth, corners, triangle_of(local.from, corners));
  const Triangle to = raised_at_held(shape, cloth, corners, triangle_of(local.to, corners));
  const double keeps = cloth.offset_at(corners[0]);
  FaceApproach result;
  const auto with_leeway = [&](std::optional<FaceDistance> distance, const Triangle& t) {
    if (distance) distance->value += leeway(cloth, corners, t, distance->weights);
    return distance;
  };
  result.distance = with_leeway(face_distance(shape, to, margin, query), to);

  const bool fast = is_fast(shape, to[0] - from[0]) || is_fast(shape, to[1] - from[1]) ||
                    is_fast(shape, to[2] - from[2]);
  const bool inside = result.distance && result.distance->value < 0;
  if (!inside && !fast) return result;

  // It may have been in the solid before, or have passed through it.
  const auto before = with_leeway(face_distance(shape, from, 0, query), from);
  if (before && before->value < 0) {
    result.before = before->value;
  } else if (fast || result.distance->value < -safe_depth(shape)) {
    const auto swept =
        with_leeway(swept_face_distance(collider, to_world(collider.previous(), from),
                                        to_world(collider.pose(), to), keeps),
                    to);
    if (swept && (!result.distance || swept->value < result.distance->value)) {
      result.distance = swept;
      result.swept = swept->value < keeps;
    }
  }
  return result;
}

}  // namespace clothsim
