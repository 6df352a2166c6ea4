#include "clothsim/search/patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Points of a patch, side by side: the first fills up what is left.
constexpr int most_points = (Patch::side + 1) * (Patch::side + 1);
constexpr int rounds = (most_points + num_lanes - 1) / num_lanes;
constexpr int room = rounds * num_lanes;

struct Ways {
  std::array<std::array<double, room>, 3> at;   // [m], from the centre
  std::array<std::array<double, room>, 3> way;  // [m]
};

double total(const Lanes& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}
double largest(const Lanes& v) {
  double most = v[0];
  for (int k = 1; k < num_lanes; ++k) most = std::max(most, v[k]);
  return most;
}

/// Sums over all places of products of two rows.
[[gnu::always_inline]] inline double product(const double* a, const double* b) {
  Lanes sum{};
  for (int r = 0; r < room; r += num_lanes) sum += lanes_at(a + r) * lanes_at(b + r);
  return total(sum);
}

/// sum (r r), sum (d r): second moments of places, and of ways by places.
struct Moments {
  Eigen::Matrix3d places;
  Eigen::Matrix3d ways;
};

CLOTHSIM_TARGET_CLONES
Moments moments(const Ways& ways) {
  Moments m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      if (j >= i) {
        m.places(row, column) = m.places(column, row) =
            product(ways.at[i].data(), ways.at[j].data());
      }
      m.ways(row, column) = product(ways.way[i].data(), ways.at[j].data());
    }
  }
  return m;
}

/// Squares of the longest of r, and of d - w x r.
CLOTHSIM_TARGET_CLONES
std::array<double, 2> longest(const Ways& ways, double wx, double wy, double wz) {
  Lanes arms{}, beyond{};
  for (int r = 0; r < room; r += num_lanes) {
    const Lanes &x = lanes_at(ways.at[0].data() + r), &y = lanes_at(ways.at[1].data() + r),
                &z = lanes_at(ways.at[2].data() + r);
    const Lanes dx = lanes_at(ways.way[0].data() + r) - (wy * z - wz * y);
    const Lanes dy = lanes_at(ways.way[1].data() + r) - (wz * x - wx * z);
    const Lanes dz = lanes_at(ways.way[2].data() + r) - (wx * y - wy * x);
    const Lanes arm = x * x + y * y + z * z, way = dx * dx + dy * dy + dz * dz;
    arms = arm > arms ? arm : arms;
    beyond = way > beyond ? way : beyond;
  }
  return {largest(arms), largest(beyond)};
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
                                              const Points& to, const Eigen::RowVector3d& common) {
  const auto count = patch.points.size();
  Ways ways;
  std::array<double, 3> centre{}, shift{};
  double way2 = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const int i = patch.points[k];
    double beyond2 = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      ways.at[a][k] = from(i, axis);
      ways.way[a][k] = to(i, axis) - from(i, axis);
      centre[a] += ways.at[a][k] / static_cast<double>(count);
      shift[a] += ways.way[a][k] / static_cast<double>(count);
      const double beyond = ways.way[a][k] - common[axis];
      beyond2 += beyond * beyond;
    }
    way2 = std::max(way2, beyond2);
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t k = 0; k < count; ++k) {
      ways.at[a][k] -= centre[a];
      ways.way[a][k] -= shift[a];
    }
    std::fill(ways.at[a].begin() + static_cast<std::ptrdiff_t>(count), ways.at[a].end(), 0.0);
    std::fill(ways.way[a].begin() + static_cast<std::ptrdiff_t>(count), ways.way[a].end(), 0.0);
  }

  // The turn that explains most: of least squares. A patch in a line may turn about it anyhow.
  const Moments m = moments(ways);
  const double trace = m.places.trace();
  const Eigen::Matrix3d inertia = (trace * (1 + 1e-6)) * Eigen::Matrix3d::Identity() - m.places;
  const Vector3 momentum(m.ways(2, 1) - m.ways(1, 2), m.ways(0, 2) - m.ways(2, 0),
                         m.ways(1, 0) - m.ways(0, 1));
  Vector3 turn = Vector3::Zero();
  if (trace > 0) turn = inertia.inverse() * momentum;
  if (!turn.allFinite()) turn.setZero();
  const auto [arm2, beyond2] = longest(ways, turn.x(), turn.y(), turn.z());
  return {{centre[0], centre[1], centre[2]},
          {shift[0], shift[1], shift[2]},
          turn,
          std::sqrt(arm2),
          std::sqrt(beyond2),
          std::sqrt(way2)};
}

void PatchMotions::follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
                          const Workers& workers) {
  motions_.resize(patches.size());
  const Eigen::RowVector3d common = (to - from).colwise().mean();
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
