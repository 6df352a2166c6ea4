#include "clothsim/search/patches.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

Vector3 centre(const Patch& patch, const Points& x) {
  Vector3 sum = Vector3::Zero();
  for (const int i : patch.points) sum += row(x, i);
  return sum / static_cast<double>(patch.points.size());
}

/// An orthonormal frame that turns with the patch: from the sum and the difference of its two
/// directions, which are perpendicular to each other. The identity where it is squeezed flat.
Eigen::Matrix3d frame(const Patch& patch, const Points& x) {
  const auto point = [&](int column, int r) {
    return row(x, patch.points[static_cast<std::size_t>(r * patch.columns + column)]);
  };
  Vector3 along_row = Vector3::Zero(), along_column = Vector3::Zero();
  for (int r = 0; r < patch.rows; ++r) along_row += point(patch.columns - 1, r) - point(0, r);
  for (int c = 0; c < patch.columns; ++c) along_column += point(c, patch.rows - 1) - point(c, 0);
  along_row.normalize();
  along_column.normalize();
  const Vector3 sum = along_row + along_column, difference = along_row - along_column;
  constexpr double flat = 1e-3;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  if (std::min(sum.norm(), difference.norm()) < flat) return axes;
  axes.col(0) = sum.normalized();
  axes.col(2) = axes.col(0).cross(difference).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

}  // namespace

std::vector<Patch> cut_into_patches(const Cloth& cloth, int size) {
  std::vector<Patch> patches;
  for (int first_row = 0; first_row < cloth.rows - 1; first_row += size) {
    for (int first_column = 0; first_column < cloth.columns - 1; first_column += size) {
      const int last_row = std::min(first_row + size, cloth.rows - 1);
      const int last_column = std::min(first_column + size, cloth.columns - 1);
      Patch patch{last_column - first_column + 1, last_row - first_row + 1, {}, {}};
      for (int r = first_row; r <= last_row; ++r) {
        for (int c = first_column; c <= last_column; ++c) {
          patch.points.push_back(r * cloth.columns + c);
          if (r < last_row && c < last_column) patch.cells.push_back(r * (cloth.columns - 1) + c);
        }
      }
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

void PatchMotions::follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
                          const Workers& workers) {
  motions_.resize(patches.size());
  const auto follow_one = [&](const Patch& patch) -> Motion {
    Motion motion{centre(patch, from),
                  centre(patch, to),
                  frame(patch, to) * frame(patch, from).transpose(),
                  0,
                  0,
                  {}};
    double radius2 = 0, strain2 = 0;
    for (const int i : patch.points) {
      const Vector3 arm = row(from, i) - motion.from;
      radius2 = std::max(radius2, arm.squaredNorm());
      const Vector3 astray = row(to, i) - motion.to - motion.rotation * arm;
      strain2 = std::max(strain2, astray.squaredNorm());
      motion.ways.extend(Vector3(row(to, i) - row(from, i)));
    }
    motion.radius = std::sqrt(radius2);
    motion.strain = std::sqrt(strain2);
    return motion;
  };
  workers.share(
      static_cast<int>(patches.size()),
      [&](int begin, int end) {
        for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
          motions_[k] = follow_one(patches[k]);
        }
      },
      Workers::dear);
}

double PatchMotions::between(int p, int q) const {
  const Motion& a = motions_[static_cast<std::size_t>(p)];
  const Motion& b = motions_[static_cast<std::size_t>(q)];
  // Seen from a, the centre of b has moved and its frame has turned, by as much as the difference
  // of two rotations stretches an arm: its Frobenius norm over the root of 2.
  const Vector3 shift = b.to - a.to - a.rotation * (b.from - a.from);
  const double turn = std::sqrt((b.rotation - a.rotation).squaredNorm() / 2);
  const double as_bodies = shift.norm() + turn * b.radius + a.strain + b.strain;
  const Vector3 as_points = (a.ways.max() - b.ways.min()).cwiseMax(b.ways.max() - a.ways.min());
  return std::min(as_bodies, as_points.norm());
}

}  // namespace clothsim
