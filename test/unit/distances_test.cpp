#include "clothsim/geometry/distances.h"

#include <algorithm>
#include <array>
#include <limits>

#include "clothsim/search/surface_pair.h"
#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

TEST(Distances, AreThoseOfEachPair) {
  // Of any points: also of triangles and edges without extent, and of features that meet.
  const int count = 40;
  Points x = random_points(count, 1, 3);
  for (int i = 0; i < 10; ++i) x.row(i) = x.row(i + 10);               // the same twice
  for (int i = 20; i < 30; ++i) x.row(i).tail(2) = x.row(20).tail(2);  // on a line
  std::vector<SurfacePair> pairs;
  std::uint64_t random = 1;
  const auto draw = [&] {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return static_cast<int>((random >> 33) % count);
  };
  double most = 0;
  int at_edges = 0, inside = 0;
  Distances distances;
  for (int round = 0; round < 20; ++round) {
    pairs.clear();
    distances.clear();
    while (distances.room() > 0) {
      pairs.push_back({0, {draw(), draw(), draw(), draw()}, 0});
      distances.add(pairs.back().points);
    }
    distances.measure(x);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Separation s = separation(pairs[k], x);
      const double exact = s.distance;
      EXPECT_LE(distances[k], exact + 1e-12);
      EXPECT_GE(distances[k], (1 - 1e-10) * exact - 1e-6);
      most = std::max(most, exact);
      const auto& [a, b, c, d] = pairs[k].points;
      const auto side = [&](int from, int to) -> Vector3 { return row(x, to) - row(x, from); };
      const double area = side(b, c).cross(side(b, d)).norm();
      if (exact < 1e-3 || area < 1e-3) continue;
      const bool at_edge =
          std::any_of(s.weights.begin(), s.weights.end(), [](double w) { return w == 0; });
      EXPECT_EQ(distances.at_edge(k), at_edge);
      ++(at_edge ? at_edges : inside);
    }
  }
  EXPECT_GT(most, 1);
  EXPECT_GT(at_edges, 100);
  EXPECT_GT(inside, 100);
}

/// The same in extended precision: to the plane where the foot is inside, otherwise to an edge.
long double exact_distance(const Points& x, const std::array<int, 4>& points) {
  using Vector = Eigen::Matrix<long double, 3, 1>;
  const auto at = [&](std::size_t k) -> Vector { return row(x, points[k]).cast<long double>(); };
  const Vector p = at(0);
  const std::array<Vector, 3> corners{at(1), at(2), at(3)};
  // Two directions in the plane, the second one freed of the first twice, as one is not enough.
  const Vector u = (corners[1] - corners[0]).normalized();
  Vector v = corners[2] - corners[0];
  for (int k = 0; k < 2; ++k) v = (v - v.dot(u) * u).normalized().eval();
  const Vector way = p - corners[0];
  const Vector normal = way - way.dot(u) * u - way.dot(v) * v;

  bool inside = true;
  long double least = std::numeric_limits<long double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector &a = corners[k], &b = corners[(k + 1) % 3], &c = corners[(k + 2) % 3];
    const Vector along = b - a;
    const Vector inward = c - a - (c - a).dot(along) / along.squaredNorm() * along;
    inside = inside && inward.dot(p - a) >= 0;
    const long double t = (p - a).dot(along) / along.squaredNorm();
    least = std::min(least, (p - a - std::clamp(t, 0.0L, 1.0L) * along).norm());
  }
  return inside ? normal.norm() : least;
}

TEST(Distances, OfPointsAboveNeedlesAreNeverMoreThanTheyAre) {
  // Of all lengths 1, ever thinner, each at some place of its own.
  for (double height = 1; height > 1e-9; height /= 3) {
    Distances distances;
    const int count = 60;
    Points x(4 * count, 3);
    const Points random = random_points(3 * count, 1, 5);
    double worst = 0;
    for (int i = 0; i < count; ++i) {
      const Vector3 place = 0.1 * row(random, i);
      const Vector3 along = row(random, count + i).normalized();
      const Vector3 aside = along.cross(row(random, 2 * count + i)).normalized();
      const Vector3 up = along.cross(aside);
      x.row(4 * i) = (place + 0.4 * along + 0.3 * height * aside + up).transpose();
      x.row(4 * i + 1) = place.transpose();
      x.row(4 * i + 2) = (place + along).transpose();
      x.row(4 * i + 3) = (place + 0.5 * along + height * aside).transpose();
      distances.add({4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3});
    }
    distances.measure(x);
    for (int i = 0; i < count; ++i) {
      const auto exact =
          static_cast<double>(exact_distance(x, {4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3}));
      EXPECT_LE(distances[static_cast<std::size_t>(i)], exact) << "height " << height;
      worst = std::max(worst, exact - distances[static_cast<std::size_t>(i)]);
    }
    EXPECT_LT(worst, 1e-6) << "height " << height;
  }
}

}  // namespace
}  // namespace clothsim
