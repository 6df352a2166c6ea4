#include "clothsim/search/patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Points of a patch, side by side, and zeros up to whole lanes.
constexpr int most_points = (Patch::side + 1) * (Patch::side + 1);
constexpr int room = (most_points + num_lanes - 1) / num_lanes * num_lanes;
using Column = std::array<double, room>;

struct Ways {
  std::array<Column, 3> at;   // [m], from the centre
  std::array<Column, 3> way;  // [m], beyond the mean
  std::array<double, 3> centre;
  std::array<double, 3> shift;
};

double total(const Lanes& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}
double largest(const Lanes& v) {
  double most = v[0];
  for (int k = 1; k < num_lanes; ++k) most = std::max(most, v[k]);
  return most;
}

/// Sum over all places, of one column or of the products of two.
[[gnu::always_inline]] inline double sum(const Column& a) {
  Lanes result{};
  for (std::size_t r = 0; r < room; r += num_lanes) result += lanes_at(a.data() + r);
  return total(result);
}
[[gnu::always_inline]] inline double product(const Column& a, const Column& b) {
  Lanes result{};
  for (std::size_t r = 0; r < room; r += num_lanes) {
    result += lanes_at(a.data() + r) * lanes_at(b.data() + r);
  }
  return total(result);
}

/// Takes the mean of the first `count` off a column.
[[gnu::always_inline]] inline double centred(Column& column, std::size_t count) {
  const double mean = sum(column) / static_cast<double>(count);
  for (std::size_t k = 0; k < count; ++k) column[k] -= mean;
  return mean;
}

/// Second moments of places, and of ways by places.
struct Moments {
  Eigen::Matrix3d places;
  Eigen::Matrix3d ways;
};

CLOTHSIM_TARGET_CLONES
void centre(Ways& ways, std::size_t count) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ways.centre[axis] = centred(ways.at[axis], count);
    ways.shift[axis] = centred(ways.way[axis], count);
  }
}

CLOTHSIM_TARGET_CLONES
Moments moments(const Ways& ways) {
  Moments m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      if (j >= i) m.places(row, column) = m.places(column, row) = product(ways.at[i], ways.at[j]);
      m.ways(row, column) = product(ways.way[i], ways.at[j]);
    }
  }
  return m;
}

/// Squares of the longest of r, of d - w x r, and of d and a shift.
CLOTHSIM_TARGET_CLONES
std::array<double, 3> longest(const Ways& ways, double wx, double wy, double wz, double sx,
                              double sy, double sz) {
  Lanes arms{}, beyond{}, all{};
  for (std::size_t r = 0; r < room; r += num_lanes) {
    const Lanes &x = lanes_at(ways.at[0].data() + r), &y = lanes_at(ways.at[1].data() + r),
                &z = lanes_at(ways.at[2].data() + r);
    const Lanes &dx = lanes_at(ways.way[0].data() + r), &dy = lanes_at(ways.way[1].data() + r),
                &dz = lanes_at(ways.way[2].data() + r);
    const Lanes ex = dx - (wy * z - wz * y), ey = dy - (wz * x - wx * z),
                ez = dz - (wx * y - wy * x);
    const Lanes fx = dx + sx, fy = dy + sy, fz = dz + sz;
    const Lanes arm = x * x + y * y + z * z, way = ex * ex + ey * ey + ez * ez,
                whole = fx * fx + fy * fy + fz * fz;
    arms = arm > arms ? arm : arms;
    beyond = way > beyond ? way : beyond;
    all = whole > all ? whole : all;
  }
  return {largest(arms), largest(beyond), largest(all)};
}

}  // namespace

std::vector<Patch> cut_into_patches(const Cloth& cloth) {
  std::vector<Patch> patches;
  for (int first_row = 0; first_row < cloth.rows; first_row += Patch::side) {
    for (int first_column = 0; first_column < cloth.columns; first_column += Patch::side) {
      Patch patch;
      patch.tiles.fill(Patch::none);
      for (int r = 0; r <= Patch::side && first_row + r < cloth.rows; ++r) {
        for (int c = 0; c <= Patch::side && first_column + c < cloth.columns; ++c) {
          const int point = (first_row + r) * cloth.columns + first_column + c;
          patch.points.push_back(point);
          if (r == Patch::side || c == Patch::side) continue;
          patch.tiles[static_cast<std::size_t>(r * Patch::side + c)] = point;
        }
      }
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

PatchMotions::Motion PatchMotions::follow_one(const Patch& patch, const Points& from,
                                              const Points& to, const Vector3& common) {
  const auto count = patch.points.size();
  Ways ways;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* const start = from.col(static_cast<Eigen::Index>(axis)).data();
    const double* const end = to.col(static_cast<Eigen::Index>(axis)).data();
    ways.at[axis].fill(0);
    ways.way[axis].fill(0);
    for (std::size_t k = 0; k < count; ++k) {
      const int i = patch.points[k];
      ways.at[axis][k] = start[i];
      ways.way[axis][k] = end[i] - start[i];
    }
  }
  centre(ways, count);

  // The turn that explains most: of least squares. A patch in a line may turn about it anyhow.
  const Moments m = moments(ways);
  const double trace = m.places.trace();
  const Eigen::Matrix3d inertia = (trace * (1 + 1e-6)) * Eigen::Matrix3d::Identity() - m.places;
  const Vector3 momentum(m.ways(2, 1) - m.ways(1, 2), m.ways(0, 2) - m.ways(2, 0),
                         m.ways(1, 0) - m.ways(0, 1));
  Vector3 turn = Vector3::Zero();
  if (trace > 0) turn = inertia.inverse() * momentum;
  if (!turn.allFinite()) turn.setZero();
  const Vector3 shift(ways.shift[0], ways.shift[1], ways.shift[2]), own = shift - common;
  const auto [arm2, beyond2, way2] =
      longest(ways, turn.x(), turn.y(), turn.z(), own.x(), own.y(), own.z());
  return {{ways.centre[0], ways.centre[1], ways.centre[2]},
          shift,
          turn,
          std::sqrt(arm2),
          std::sqrt(beyond2),
          std::sqrt(way2)};
}

void PatchMotions::follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
                          const Workers& workers) {
  motions_.resize(patches.size());
  const Vector3 common = (to.colwise().mean() - from.colwise().mean()).transpose();
  workers.share(
      static_cast<int>(patches.size()),
      [&](int begin, int end) {
        for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
          motions_[k] = follow_one(patches[k], from, to, common);
        }
      },
      Workers::dear);
  longest_ = 0;
  for (const Motion& motion : motions_) longest_ = std::max(longest_, motion.way);
}

double PatchMotions::between(int p, int q) const {
  const Motion &a = of(p), &b = of(q);
  const Vector3 turn = (a.turn + b.turn) / 2, half_difference = (a.turn - b.turn) / 2;
  const Vector3 shift = a.shift - b.shift - turn.cross(a.centre - b.centre);
  return std::min(
      shift.norm() + half_difference.norm() * (a.radius + b.radius) + a.strain + b.strain,
      at_most(p, q));
}

}  // namespace clothsim
