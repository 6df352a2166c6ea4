#include "clothsim/simulation/cloth_size.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Calls visit(first point, points) for each cloth.
template <typename Visit>
void for_each_cloth(const Cloth& cloth, const Visit& visit) {
  const std::size_t count = cloth.first_points.size();
  if (count == 0) visit(0, cloth.num_points());
  for (std::size_t i = 0; i < count; ++i) {
    const int end = i + 1 < count ? cloth.first_points[i + 1] : cloth.num_points();
    visit(cloth.first_points[i], end - cloth.first_points[i]);
  }
}

}  // namespace

double cells_along(const Cloth& cloth) {
  if (!cloth.is_mesh()) return std::max(cloth.columns, cloth.rows);
  double most = 0;
  for_each_cloth(cloth, [&](int, int points) { most = std::max(most, std::sqrt(points)); });
  return most;
}

Eigen::RowVector3d extent_of(const Cloth& cloth) {
  Eigen::RowVector3d largest = Eigen::RowVector3d::Zero();
  for_each_cloth(cloth, [&](int first, int points) {
    const auto own = cloth.rest_positions.middleRows(first, points);
    const Eigen::RowVector3d extent = own.colwise().maxCoeff() - own.colwise().minCoeff();
    if (extent.maxCoeff() > largest.maxCoeff()) largest = extent;
  });
  return largest;
}

}  // namespace clothsim
