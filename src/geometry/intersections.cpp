#include "clothsim/geometry/intersections.h"

#include <algorithm>
#include <cassert>
#include <tuple>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/geometry/orientation.h"

namespace clothsim {
namespace {

/// The side of the plane of `t` on which each corner of `s` lies.
std::array<int, 3> sides_of(const Triangle& t, const Triangle& s) {
  std::array<int, 3> sides;
  for (std::size_t i = 0; i < 3; ++i) sides[i] = orientation(t[0], t[1], t[2], s[i]);
  return sides;
}

bool on_both_sides(const std::array<int, 3>& sides) {
  const auto [least, most] = std::minmax({sides[0], sides[1], sides[2]});
  return least < 0 && most > 0;
}

/// The corner that is alone on its side of the plane, where there are corners on both sides.
std::size_t lone_corner(const std::array<int, 3>& sides) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (sides[i] != 0 && sides[(i + 1) % 3] != sides[i] && sides[(i + 2) % 3] != sides[i]) return i;
  }
  assert(false);
  return 0;
}

bool share_a_point(const std::array<int, 3>& s, const std::array<int, 3>& t) {
  return std::any_of(s.begin(), s.end(),
                     [&t](int i) { return i == t[0] || i == t[1] || i == t[2]; });
}

}  // namespace

bool triangles_cross(const Triangle& s, const Triangle& t) {
  // Each triangle must reach through the plane of the other.
  const std::array<int, 3> sides_s = sides_of(t, s);
  if (!on_both_sides(sides_s)) return false;
  const std::array<int, 3> sides_t = sides_of(s, t);
  if (!on_both_sides(sides_t)) return false;

  // Permute both so that the first corner is alone, above the plane of the other.
  const std::size_t i = lone_corner(sides_s), j = lone_corner(sides_t);
  Triangle p{s[i], s[(i + 1) % 3], s[(i + 2) % 3]};
  Triangle q{t[j], t[(j + 1) % 3], t[(j + 2) % 3]};
  if (sides_s[i] < 0) std::swap(q[1], q[2]);
  if (sides_t[j] < 0) std::swap(p[1], p[2]);

  // Each triangle cuts an interval out of the line where the planes meet, from edge 0-2 to 0-1 and
  // from 0-1 to 0-2: do the intervals overlap?
  return orientation(p[0], p[1], q[0], q[1]) < 0 && orientation(p[0], p[2], q[2], q[0]) < 0;
}

std::vector<TrianglePair> find_intersections(const Cloth& cloth, const Points& positions) {
  assert(positions.allFinite());
  std::vector<Triangle> triangles;
  std::vector<Box> boxes;
  triangles.reserve(cloth.triangles.size());
  boxes.reserve(cloth.triangles.size());
  for (const auto& [i, j, k] : cloth.triangles) {
    triangles.push_back({positions.row(i), positions.row(j), positions.row(k)});
    const auto& [a, b, c] = triangles.back();
    boxes.emplace_back(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c));
  }

  std::vector<TrianglePair> pairs;
  BoxTree(boxes).visit_overlaps([&](int a, int b) {
    const auto s = static_cast<std::size_t>(a), t = static_cast<std::size_t>(b);
    if (share_a_point(cloth.triangles[s], cloth.triangles[t])) return;
    if (triangles_cross(triangles[s], triangles[t])) pairs.push_back({a, b});
  });
  std::sort(pairs.begin(), pairs.end(), [](const TrianglePair& p, const TrianglePair& q) {
    return std::tie(p.a, p.b) < std::tie(q.a, q.b);
  });
  return pairs;
}

int count_intersections(const Cloth& cloth, const Points& positions) {
  return static_cast<int>(find_intersections(cloth, positions).size());
}

}  // namespace clothsim
