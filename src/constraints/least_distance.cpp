#include "clothsim/constraints/least_distance.h"

#include <algorithm>

#include "clothsim/shapes/face_distance.h"

namespace clothsim {
namespace {

/// The same from one collider, with positions in its own frame.
double distance_from(const Shape& shape, const Cloth& cloth, const Points& local, double reach) {
  double least = reach;
  const auto take = [&](double distance, int point) {
    if (distance < cloth.offset_at(point)) least = std::min(least, distance);
  };
  const auto is_free = [&](int point) { return cloth.inv_mass[point] > 0; };
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (is_free(i)) take(signed_distance(shape, row(local, i), row(local, i)).value, i);
  }
  for (const auto& [a, b, c] : cloth.triangles) {
    if (!is_free(a) || !is_free(b) || !is_free(c)) continue;
    const Triangle corners = {row(local, a), row(local, b), row(local, c)};
    const auto face = face_distance(shape, corners, std::min(least, cloth.offset_at(a)));
    if (face) take(face->value, a);
  }
  return least;
}

}  // namespace

double least_distance(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                      const Points& positions) {
  const Eigen::AlignedBox3d box(positions.colwise().minCoeff().transpose(),
                                positions.colwise().maxCoeff().transpose());
  double least = cloth.offset;
  for (const MovingCollider& collider : colliders) {
    const Pose& pose = collider.pose();
    const double farthest = bounding_radius(collider.shape()) + least;
    if (!collider.enabled() || box.exteriorDistance(pose.position) > farthest) continue;
    const Points local =
        (positions.rowwise() - pose.position.transpose()) * pose.orientation.toRotationMatrix();
    least = std::min(least, distance_from(collider.shape(), cloth, local, least));
  }
  return least;
}

}  // namespace clothsim
