#include "clothsim/shapes/shells.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include "clothsim/geometry/box_tree.h"

namespace clothsim {
namespace {

/// Shells this close touch, by the solid's size: files round to single precision.
constexpr double touching = 1e-6;

struct Shell {
  TriangleSoup soup;
  Box box;
  Volume volume;                                 // below 0: a hollow
  std::shared_ptr<const Solid> solid = nullptr;  // made at the first query

  bool is_hollow() const { return volume.sum < 0 || volume.is_none(); }

  const Solid& as_solid() {
    if (!solid) solid = std::make_shared<const Solid>(soup);
    return *solid;
  }
};

/// By vertex, the first vertex that it is connected with.
std::vector<int> first_connected(const Solid& solid) {
  std::vector<int> first(solid.vertices().size());
  std::iota(first.begin(), first.end(), 0);
  const auto root = [&](int i) {
    auto at = [&](int k) -> int& { return first[static_cast<std::size_t>(k)]; };
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  };
  for (const auto& t : solid.triangles()) {
    for (std::size_t k = 1; k < t.size(); ++k) {
      const int a = root(t[0]), b = root(t[k]);
      first[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  for (int i = 0; i < static_cast<int>(first.size()); ++i) {
    first[static_cast<std::size_t>(i)] = root(i);
  }
  return first;
}

std::vector<Shell> shells_of(const Solid& solid) {
  const std::vector<int> first = first_connected(solid);
  std::vector<Shell> shells;
  std::vector<int> shell_of(first.size(), -1), place_of(first.size(), -1);
  for (const auto& t : solid.triangles()) {
    int& number = shell_of[static_cast<std::size_t>(first[static_cast<std::size_t>(t[0])])];
    if (number < 0) {
      number = static_cast<int>(shells.size());
      shells.push_back({});
    }
    Shell& shell = shells[static_cast<std::size_t>(number)];
    std::array<int, 3> corners{};
    for (std::size_t k = 0; k < corners.size(); ++k) {
      int& place = place_of[static_cast<std::size_t>(t[k])];
      if (place < 0) {
        place = static_cast<int>(shell.soup.vertices.size());
        shell.soup.vertices.push_back(solid.vertices()[static_cast<std::size_t>(t[k])]);
        shell.box.extend(shell.soup.vertices.back());
      }
      corners[k] = place;
    }
    shell.soup.triangles.push_back(corners);
    const auto at = [&](std::size_t k) -> const Vector3& {
      return shell.soup.vertices[static_cast<std::size_t>(corners[k])];
    };
    const Vector3& origin = shell.soup.vertices[0];
    shell.volume.add(at(0) - origin, at(1) - origin, at(2) - origin);
  }
  return shells;
}

/// Does any of the other's surface touch the solid, or lie in it?
bool reaches_into(const Solid& solid, const Shell& other, double near) {
  const auto& [vertices, triangles] = other.soup;
  const auto is_in = [&](const Vector3& p) {
    return squared_distance(solid.box(), Box(p)) <= near * near && solid.distance(p).first <= near;
  };
  if (std::any_of(vertices.begin(), vertices.end(), is_in)) return true;
  bool hits = false;
  for (const auto& t : triangles) {
    const auto at = [&](std::size_t k) { return vertices[static_cast<std::size_t>(t[k])]; };
    solid.visit_hits({at(0), at(1), at(2)}, nullptr,
                     [&](std::size_t, const auto&...) { hits = true; });
    if (hits) break;
  }
  return hits;
}

/// By shell, the numbers of the shells that it touches or overlaps, ascending.
std::vector<std::vector<int>> overlaps_of(std::vector<Shell>& shells, double near) {
  std::vector<Box> boxes;
  for (const Shell& shell : shells) {
    const Vector3 more = Vector3::Constant(near);
    boxes.emplace_back(shell.box.min() - more, shell.box.max() + more);
  }
  std::vector<std::vector<int>> overlaps(shells.size());
  BoxTree(boxes).visit_overlaps([&](int p, int q) {
    Shell &a = shells[static_cast<std::size_t>(p)], &b = shells[static_cast<std::size_t>(q)];
    if (a.is_hollow() || b.is_hollow()) return;
    if (!reaches_into(a.as_solid(), b, near) && !reaches_into(b.as_solid(), a, near)) return;
    overlaps[static_cast<std::size_t>(p)].push_back(q);
    overlaps[static_cast<std::size_t>(q)].push_back(p);
  });
  return overlaps;
}

/// The group of the smallest shell around a hollow; -1: none.
int group_around(const Shell& hollow, std::vector<Shell>& shells, const std::vector<int>& groups) {
  const Shell* around = nullptr;
  int group = -1;
  for (std::size_t i = 0; i < shells.size(); ++i) {
    Shell& shell = shells[i];
    if (shell.is_hollow() || !shell.box.contains(hollow.box)) continue;
    if (around && around->volume.sum <= shell.volume.sum) continue;
    if (shell.as_solid().distance(hollow.soup.vertices[0]).first > 0) continue;
    around = &shell;
    group = groups[i];
  }
  return group;
}

void append(const TriangleSoup& more, TriangleSoup& soup) {
  const int first = static_cast<int>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& [a, b, c] : more.triangles) {
    soup.triangles.push_back({first + a, first + b, first + c});
  }
}

}  // namespace

std::vector<TriangleSoup> split_overlapping(const Solid& solid) {
  std::vector<Shell> shells = shells_of(solid);
  const auto overlaps = overlaps_of(shells, touching * solid.box().diagonal().norm());

  // Each goes into the first group without a shell that it overlaps.
  std::vector<int> groups(shells.size(), -1);
  for (std::size_t i = 0; i < shells.size(); ++i) {
    if (shells[i].is_hollow()) continue;
    const auto is_taken = [&](int group) {
      return std::any_of(overlaps[i].begin(), overlaps[i].end(), [&](int other) {
        return groups[static_cast<std::size_t>(other)] == group;
      });
    };
    groups[i] = 0;
    while (is_taken(groups[i])) ++groups[i];
  }
  const int count = *std::max_element(groups.begin(), groups.end()) + 1;
  if (count <= 1) return {{solid.vertices(), solid.triangles()}};
  std::vector<TriangleSoup> result(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < shells.size(); ++i) {
    const int group = shells[i].is_hollow() ? group_around(shells[i], shells, groups) : groups[i];
    if (group >= 0) append(shells[i].soup, result[static_cast<std::size_t>(group)]);
  }
  return result;
}

}  // namespace clothsim
