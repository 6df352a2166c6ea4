// The surface of a solid: closedness, normals, ridges and thickness.

#include "clothsim/shapes/solid.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Two faces at less than this angle are one plane, but for rounding [rad].
constexpr double flat = 1e-4;

/// Below this share of the sum of its parts' magnitudes, a volume is rounding.
constexpr double min_volume = 1e-9;

/// Most triangles, spread over all, whose thickness is measured.
constexpr std::size_t max_measured = 2000;

struct HashOfPlace {
  std::size_t operator()(const Vector3& p) const {
    std::size_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      hash = hash * 1000003 + std::hash<double>()(p[axis]);  // 0.0 and -0.0 alike
    }
    return hash;
  }
};

std::string in_words(const Vector3& p) {
  return '[' + to_text(p.x()) + ", " + to_text(p.y()) + ", " + to_text(p.z()) + ']';
}

double angle_at(const Vector3& corner, const Vector3& a, const Vector3& b) {
  const Vector3 u = a - corner, v = b - corner;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// Key of a directed edge.
std::uint64_t key_of(int from, int to) {
  return static_cast<std::uint64_t>(from) << 32 | static_cast<std::uint32_t>(to);
}

/// The corner of a triangle that is neither `a` nor `b`.
const Vector3& adjacent_corner(const std::array<Vector3, 3>& t, const Vector3& a,
                               const Vector3& b) {
  return t[0] != a && t[0] != b ? t[0] : (t[1] != a && t[1] != b ? t[1] : t[2]);
}

/// Distance that a ball through the corners of two triangles turns across, from the one to the
/// other over their edge from a to b [m]: between their circumcentres, where these are not on the
/// edge.
double width_across(const std::array<Vector3, 3>& s, const std::array<Vector3, 3>& t,
                    const Vector3& a, const Vector3& b) {
  double width = 0, height = 0;
  for (const auto* triangle : {&s, &t}) {
    const Vector3& c = adjacent_corner(*triangle, a, b);
    const double area2 = (a - c).cross(b - c).norm(), length = (b - a).norm();
    width += length / 2 * (a - c).dot(b - c) / area2;
    height += area2 / length;
  }
  return std::max(width, height / 6);
}

}  // namespace

void Volume::add(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double part = a.dot(b.cross(c)) / 6;
  sum += part;
  parts += std::abs(part);
}

bool Volume::is_none() const { return !(std::abs(sum) > min_volume * parts); }  // so NaN is none

Solid::Solid(const TriangleSoup& soup, Bounds bounds) : is_sheet_(bounds == Bounds::sheet) {
  weld(soup);
  if (!is_sheet_) orient();
  add_faces();
  is_sheet_ ? connect_sheet() : connect();
  std::vector<Box> boxes;
  for (const Corners& corners : corners_) {
    Box box;
    for (const Vector3& p : corners) box.extend(p);
    boxes.push_back(box);
    box_.extend(box);
    for (const Vector3& p : corners) radius_ = std::max(radius_, p.norm());
  }
  face_tree_ = NearestTree(boxes);
  boxes.clear();
  for (const Ridge& ridge : ridges_) boxes.push_back(Box(ridge.ends[0]).extend(ridge.ends[1]));
  ridge_tree_ = NearestTree(boxes);
  wrap_faces();
  build_grid();
  thickness_ = is_sheet_ ? 0 : measure_thickness();
}

void Solid::weld(const TriangleSoup& soup) {
  std::unordered_map<Vector3, int, HashOfPlace> known;
  std::vector<int> welded;
  welded.reserve(soup.vertices.size());
  for (const Vector3& p : soup.vertices) {
    if (!p.allFinite()) throw InvalidValue({}, "a vertex that is not finite", "a finite place");
    const auto [place, is_new] = known.emplace(p, static_cast<int>(vertices_.size()));
    if (is_new) vertices_.push_back(p);
    welded.push_back(place->second);
  }
  for (const auto& [a, b, c] : soup.triangles) {
    const auto at = [&](int i) { return welded[static_cast<std::size_t>(i)]; };
    if (at(a) == at(b) || at(b) == at(c) || at(c) == at(a)) continue;
    triangles_.push_back({at(a), at(b), at(c)});
  }
  if (triangles_.empty()) throw InvalidValue({}, "no triangles", "a surface");
}

void Solid::orient() {
  Volume volume;
  for (const auto& [a, b, c] : triangles_) {
    const auto at = [&](int i) -> Vector3 {
      return vertices_[static_cast<std::size_t>(i)] - vertices_[0];
    };
    volume.add(at(a), at(b), at(c));
  }
  if (volume.sum < 0) {
    for (auto& [a, b, c] : triangles_) std::swap(b, c);
  }
  if (volume.is_none()) {
    throw InvalidValue({}, "a surface without a volume inside",
                       "a solid, or a sheet with a thickness");
  }
}

void Solid::add_faces() {
  vertex_normals_.assign(vertices_.size(), Vector3::Zero());
  for (const std::array<int, 3>& triangle : triangles_) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = vertices_[static_cast<std::size_t>(triangle[k])];
    }
    corners_.push_back(corners);
    const Vector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const Vector3 none = Vector3::Zero();
    faces_.push_back({normal.stableNormalized(), {none, none, none}});
    for (std::size_t k = 0; k < 3; ++k) {
      vertex_normals_[static_cast<std::size_t>(triangle[k])] +=
          angle_at(corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]) * faces_.back().normal;
    }
  }
}

void Solid::connect() {
  const auto at = [&](int i) -> const Vector3& { return vertices_[static_cast<std::size_t>(i)]; };
  std::unordered_map<std::uint64_t, std::pair<int, int>> sides;  // of directed edges: face, corner
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = triangles_[t][k], to = triangles_[t][(k + 1) % 3];
      const std::pair<int, int> side(static_cast<int>(t), static_cast<int>(k));
      if (sides.emplace(key_of(from, to), side).second) continue;
      throw InvalidValue(
          {},
          "more than two triangles, or two of opposite sense, at the edge from " +
              in_words(at(from)) + " to " + in_words(at(to)),
          "each edge between two triangles of one sense, or a sheet with a thickness");
    }
  }
  std::vector<std::array<int, 3>> beyond(faces_.size());  // faces across the edge from corner k on
  for (std::size_t t = 0; t < faces_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = triangles_[t][k], to = triangles_[t][(k + 1) % 3];
      const auto other = sides.find(key_of(to, from));
      if (other == sides.end()) {
        throw InvalidValue(
            {}, "a hole at the edge from " + in_words(at(from)) + " to " + in_words(at(to)),
            "a closed surface, or a sheet with a thickness");
      }
      beyond[t][k] = other->second.first;
      faces_[t].edge_normals[k] =
          faces_[t].normal + faces_[static_cast<std::size_t>(beyond[t][k])].normal;
    }
  }
  find_ridges(beyond);
}

void Solid::find_ridges(const std::vector<std::array<int, 3>>& beyond) {
  for (std::size_t t = 0; t < faces_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 &a = corners_[t][k], &b = corners_[t][(k + 1) % 3];
      const auto other = static_cast<std::size_t>(beyond[t][k]);
      if (other < t) continue;  // each edge once
      const Vector3 &n = faces_[t].normal, &m = faces_[other].normal;
      const Vector3 along = (b - a).stableNormalized();
      const double angle = std::atan2(n.cross(m).dot(along), n.dot(m));  // outwards
      if (!(angle > flat)) continue;
      add_ridge(t, k, n + m, angle);
      sharpest_ = std::max(sharpest_, angle);
      curvature_ = std::max(curvature_, angle / width_across(corners_[t], corners_[other], a, b));
    }
  }
}

/// An edge of a sheet may belong to any number of triangles, of either sense.
void Solid::connect_sheet() {
  std::unordered_map<std::uint64_t, std::vector<std::pair<std::size_t, std::size_t>>> sides;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles_[t][k], triangles_[t][(k + 1) % 3]);
      sides[key_of(low, high)].push_back({t, k});
    }
  }
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles_[t][k], triangles_[t][(k + 1) % 3]);
      const auto& all = sides[key_of(low, high)];
      for (const auto& side : all) faces_[t].edge_normals[k] += faces_[side.first].normal;
      if (all.front() != std::pair(t, k)) continue;  // each edge once
      double angle = M_PI;
      if (all.size() == 2) {
        const Vector3 &n = faces_[t].normal, &m = faces_[all[1].first].normal;
        angle = std::atan2(n.cross(m).norm(), std::abs(n.dot(m)));
        const Vector3 &a = corners_[t][k], &b = corners_[t][(k + 1) % 3];
        const Vector3 into = adjacent_corner(corners_[t], a, b) - a;
        const Vector3 other = adjacent_corner(corners_[all[1].first], a, b) - a;
        const Vector3 along = (b - a).stableNormalized();
        const bool is_folded =
            (into - along.dot(into) * along).dot(other - along.dot(other) * along) > 0;
        if (is_folded) angle = M_PI - angle;
      }
      if (angle > flat) add_ridge(t, k, faces_[t].edge_normals[k], angle);
    }
  }
}

void Solid::add_ridge(std::size_t face, std::size_t corner, const Vector3& normal, double angle) {
  const std::size_t next = (corner + 1) % 3;
  const auto end_normal = [&](std::size_t k) {
    return vertex_normals_[static_cast<std::size_t>(triangles_[face][k])];
  };
  ridges_.push_back({{corners_[face][corner], corners_[face][next]},
                     normal,
                     {end_normal(corner), end_normal(next)},
                     angle});
}

double Solid::dip(double edge) const {
  // Over a single ridge both ends lie on its slopes, half an edge away; over many ridges, which
  // form a ball, the triangle lies within edge / sqrt(3) of its circumcentre.
  return std::max(edge / 4 * sharpest_, edge * edge / 6 * curvature_);
}

double Solid::thickness_below(std::size_t face) const {
  const Corners& corners = corners_[face];
  const Vector3 in = -faces_[face].normal;
  const Vector3 from = (corners[0] + corners[1] + corners[2]) / 3 + smallest * radius_ * in;
  double least = std::numeric_limits<double>::max();  // finite: skips boxes off the ray
  face_tree_.search([&](const Box& box) { return hit_by_ray(from, in, box); }, least,
                    [&](int i) {
                      if (static_cast<std::size_t>(i) == face) return;
                      least = std::min(least,
                                       hit_by_ray(from, in, corners_[static_cast<std::size_t>(i)]));
                    });
  return least;
}

double Solid::measure_thickness() const {
  const std::size_t every = (faces_.size() + max_measured - 1) / max_measured;
  std::vector<double> found;
  for (std::size_t face = 0; face < faces_.size(); face += every) {
    if (faces_[face].normal.isZero(0)) continue;
    const double here = thickness_below(face);
    if (here < std::numeric_limits<double>::max()) found.push_back(here);
  }
  if (found.empty()) return box_.sizes().minCoeff();
  std::sort(found.begin(), found.end());
  return found[found.size() / 100];
}

}  // namespace clothsim
