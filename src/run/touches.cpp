#include "clothsim/run/touches.h"

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/shapes/face_distance.h"

namespace clothsim {
namespace {

/// Points within this of their contact distance are in contact [m]: the contact distance from the
/// surface once more, which exceeds the jitter of a point at rest.
constexpr double touch_reach = surface_offset;

/// Adds up positions in the collider's own frame.
void add_touches(const Shape& shape, const Clearance& keeps, const Cloth& cloth,
                 const Points& local, Touch& touch) {
  const double reach = keeps.points + touch_reach;
  Scalars distances(cloth.num_points());
  for (int i = 0; i < cloth.num_points(); ++i) {
    distances[i] = signed_distance(shape, row(local, i), row(local, i)).value;
    distances[i] += cloth.nearer_by(i);
    if (distances[i] > reach) continue;
    ++touch.count;
    touch.middle += row(local, i);
  }
  if (!keeps.faces) return;
  for (const auto& [a, b, c] : cloth.triangles) {
    if (distances[a] <= reach || distances[b] <= reach || distances[c] <= reach) continue;
    const Triangle corners = {row(local, a), row(local, b), row(local, c)};
    const auto nearest = face_distance(shape, corners, reach - cloth.nearer_by(a));
    if (!nearest) continue;
    ++touch.count;
    for (std::size_t i = 0; i < 3; ++i) touch.middle += nearest->weights[i] * corners[i];
  }
}

}  // namespace

std::vector<Touch> find_touches(const Simulator& simulator) {
  const Cloth& cloth = simulator.cloth();
  const Points& positions = simulator.state().positions;
  const std::vector<ColliderSpec>& colliders = simulator.scene().colliders;
  std::vector<Touch> touches(colliders.size());
  const Eigen::AlignedBox3d box(positions.colwise().minCoeff().transpose(),
                                positions.colwise().maxCoeff().transpose());
  const double stretch = cloth.strain_limit ? worst_stretch(cloth, positions) : 0;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    if (!simulator.collider_enabled(static_cast<int>(i))) continue;
    const Shape& shape = colliders[i].shape;
    const Pose& pose = simulator.collider_pose(static_cast<int>(i));
    const Clearance keeps = clearance(shape, cloth, stretch);
    const double farthest = bounding_radius(shape) + keeps.points + touch_reach;
    if (box.exteriorDistance(pose.position) > farthest) continue;  // true for most links of a robot
    const Points local =
        (positions.rowwise() - pose.position.transpose()) * pose.orientation.toRotationMatrix();
    Touch& touch = touches[i];
    add_touches(shape, keeps, cloth, local, touch);
    if (touch.count == 0) continue;
    touch.middle = pose.position + pose.orientation * (touch.middle / touch.count);
  }
  return touches;
}

}  // namespace clothsim
