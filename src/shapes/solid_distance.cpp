// Which triangle of a solid is nearest to a point.

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Cells by triangles: two to a triangle's edge or so, about the surface. At least enough for a
/// box, and at most 16 MB of them.
constexpr double cells_by_triangle = 64;
constexpr double fewest_cells = 4096;
constexpr double most_cells = 4e6;

/// Cells whose points are farther away than this and half a cell have no list: more than points
/// that touch stand off a smooth solid [m], but no more than two cells, of which a fine mesh has
/// many.
constexpr double widest_band = 2e-3;
constexpr double band_cells = 2;

/// A distance so small has no direction but for rounding, of the solid's size.
constexpr double smallest_gap = 1e-11;

/// A corner's weight so small is but rounding.
constexpr double on_border = 1e-9;

/// Triangles whose thickness is measured, spread over all.
constexpr std::size_t most_measured = 2000;

/// Large cells along the longest side, for which distances are known at the centre. What is farther
/// away than one of them is far.
constexpr double far_cells = 24;

/// What float's rounding may take from a distance.
constexpr double just_below = 1 - 1e-6;

}  // namespace

void Solid::look_at(int index, const Vector3& point, Nearest& nearest) const {
  const auto& [a, b, c] = corners_[static_cast<std::size_t>(index)];
  const std::array<double, 3> w = closest_on_triangle(point, a, b, c);
  const Vector3 gap = point - (w[0] * a + w[1] * b + w[2] * c);
  const double squared = gap.squaredNorm();
  if (squared < nearest.squared) nearest = {squared, index, gap, w};
}

Solid::Nearest Solid::nearest_by_tree(const Vector3& point, double most) const {
  Nearest nearest{infinity, -1, Vector3::Zero(), {1, 0, 0}};
  double most2 = most * most;
  face_tree_.search([&](const Box& box) { return squared_distance(box, point); }, most2,
                    [&](int i) {
                      look_at(i, point, nearest);
                      most2 = std::min(most2, nearest.squared);
                    });
  return nearest;
}

Vector3 Solid::normal_at(const Nearest& nearest) const {
  const auto face = static_cast<std::size_t>(nearest.face);
  const std::array<double, 3>& w = nearest.weights;
  for (std::size_t k = 0; k < 3; ++k) {
    if (w[k] >= 1 - on_border)
      return vertex_normals_[static_cast<std::size_t>(triangles_[face][k])];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (w[(k + 2) % 3] <= on_border) return faces_[face].edge_normals[k];
  }
  return faces_[face].normal;
}

std::pair<double, Vector3> Solid::distance(const Vector3& point) const {
  const int cell = cell_of(point);
  const bool listed = cell >= 0 && first_of_[static_cast<std::size_t>(cell)] <
                                       first_of_[static_cast<std::size_t>(cell) + 1];
  Nearest nearest{infinity, -1, Vector3::Zero(), {1, 0, 0}};
  if (listed) {
    const double off = (point - center_of(cell)).norm();
    const Eigen::Vector3f at = point.cast<float>();
    float best = std::numeric_limits<float>::infinity();
    const int end = first_of_[static_cast<std::size_t>(cell) + 1];
    for (int i = first_of_[static_cast<std::size_t>(cell)]; i < end; ++i) {
      const Candidate& candidate = candidates_[static_cast<std::size_t>(i)];
      const double least = candidate.least - off;
      if (least > 0 && least * least > nearest.squared) break;
      const Ball& ball = balls_[static_cast<std::size_t>(candidate.face)];
      const float x = at.x() - ball.x, y = at.y() - ball.y, z = at.z() - ball.z;
      const float reach = best + ball.radius;
      if (x * x + y * y + z * z > reach * reach) continue;
      look_at(candidate.face, point, nearest);
      best = std::sqrt(static_cast<float>(nearest.squared));
    }
  } else {
    nearest = nearest_by_tree(point, infinity);
  }
  const Vector3 normal = normal_at(nearest);
  const double value = std::sqrt(nearest.squared);
  const double sign = nearest.gap.dot(normal) < 0 ? -1 : 1;
  if (value > smallest_gap * radius_) return {sign * value, sign / value * nearest.gap};
  const Vector3 unit = normal.stableNormalized();
  return {sign * value, unit.isZero(0) ? Vector3::UnitZ() : unit};
}

std::pair<double, Vector3> Solid::rough_distance(const Vector3& point) const {
  if (far_.empty()) return distance(point);
  const double beyond2 = squared_distance(box_, point);
  if (beyond2 > far_cell_ * far_cell_) {
    return {std::sqrt(beyond2), (point - box_.center()).normalized()};
  }
  std::array<int, 3> at{};
  Vector3 center;
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const double along = (point[axis] - box_.min()[axis]) / far_cell_;
    at[k] = std::clamp(static_cast<int>(along), 0, far_cells_[k] - 1);
    center[axis] = box_.min()[axis] + (at[k] + 0.5) * far_cell_;
  }
  const FarCell& cell =
      far_[static_cast<std::size_t>((at[2] * far_cells_[1] + at[1]) * far_cells_[0] + at[0])];
  const double off = (point - center).norm();
  if (std::abs(cell.value) - off < far_cell_) return distance(point);
  return {cell.value - std::copysign(off, cell.value), cell.normal};
}

void Solid::build_far_grid() {
  far_cell_ = box_.sizes().maxCoeff() / far_cells;
  for (int axis = 0; axis < 3; ++axis) {
    far_cells_[static_cast<std::size_t>(axis)] =
        std::max(1, static_cast<int>(std::ceil(box_.sizes()[axis] / far_cell_)));
  }
  for (int z = 0; z < far_cells_[2]; ++z) {
    for (int y = 0; y < far_cells_[1]; ++y) {
      for (int x = 0; x < far_cells_[0]; ++x) {
        const Vector3 center = box_.min() + far_cell_ * Vector3(x + 0.5, y + 0.5, z + 0.5);
        const auto [value, normal] = distance(center);
        far_.push_back({value, normal});
      }
    }
  }
}

int Solid::cell_of(const Vector3& point) const {
  int index = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const double at = (point[axis] - box_.min()[axis]) / cell_ + 1;  // one cell beyond the box
    if (!(at >= 0 && at < cells_[static_cast<std::size_t>(axis)])) return -1;
    index = index * cells_[static_cast<std::size_t>(axis)] + static_cast<int>(at);
  }
  return index;
}

Vector3 Solid::center_of(int cell) const {
  Vector3 center;
  for (int axis = 0; axis < 3; ++axis) {
    const int along = cells_[static_cast<std::size_t>(axis)];
    center[axis] = box_.min()[axis] + (cell % along - 0.5) * cell_;
    cell /= along;
  }
  return center;
}

void Solid::wrap_faces() {
  // What rounds, of numbers as large as the solid and of a distance.
  const double rounding = 4 * std::numeric_limits<float>::epsilon() * 3 * radius_;
  for (const Corners& corners : corners_) {
    const Vector3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    double radius = 0;
    for (const Vector3& p : corners) radius = std::max(radius, (p - middle).norm());
    const Eigen::Vector3f at = middle.cast<float>();
    balls_.push_back({at.x(), at.y(), at.z(), static_cast<float>(radius + rounding)});
  }
}

double Solid::band() const { return std::min(widest_band, band_cells * cell_); }

void Solid::build_grid() {
  const double wanted =
      std::clamp(cells_by_triangle * static_cast<double>(faces_.size()), fewest_cells, most_cells);
  // Of a flat solid as many as of a cube.
  const double longest = box_.sizes().maxCoeff();
  const Vector3 sizes = box_.sizes().cwiseMax(longest / 1000);
  cell_ = std::cbrt(sizes.prod() / wanted);
  for (int axis = 0; axis < 3; ++axis) {
    cells_[static_cast<std::size_t>(axis)] =
        static_cast<int>(std::ceil(box_.sizes()[axis] / cell_)) + 2;
  }
  const double half = std::sqrt(3.0) / 2 * cell_;
  const std::vector<char> near = cells_near_surface(half + band());
  first_of_.assign(near.size() + 1, 0);
  for (std::size_t cell = 0; cell < near.size(); ++cell) {
    first_of_[cell] = static_cast<int>(candidates_.size());
    if (near[cell]) find_candidates(center_of(static_cast<int>(cell)), half);
  }
  first_of_.back() = static_cast<int>(candidates_.size());
}

/// By cell: whether a triangle's box comes as near to it.
std::vector<char> Solid::cells_near_surface(double reach) const {
  std::vector<char> near(static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) *
                         static_cast<std::size_t>(cells_[2]));
  for (const Corners& corners : corners_) {
    std::array<int, 3> low{}, high{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      const auto [least, most] =
          std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
      const auto at = [&](double x) {
        return std::clamp(static_cast<int>(std::floor((x - box_.min()[axis]) / cell_)) + 1, 0,
                          cells_[k] - 1);
      };
      low[k] = at(least - reach);
      high[k] = at(most + reach);
    }
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        const auto row =
            static_cast<std::size_t>((z * cells_[1] + y)) * static_cast<std::size_t>(cells_[0]);
        std::fill(near.begin() + static_cast<std::ptrdiff_t>(row) + low[0],
                  near.begin() + static_cast<std::ptrdiff_t>(row) + high[0] + 1, char{1});
      }
    }
  }
  return near;
}

void Solid::find_candidates(const Vector3& center, double half) {
  const Nearest nearest = nearest_by_tree(center, half + band());
  if (nearest.face < 0 || nearest.squared > std::pow(half + band(), 2)) return;
  // A point of the cell is no farther than half a diagonal from the centre, and so is its distance
  // from any triangle.
  const double most = std::sqrt(nearest.squared) + 2 * half;
  double most2 = most * most;
  const auto first = static_cast<std::ptrdiff_t>(candidates_.size());
  face_tree_.search(
      [&](const Box& box) { return squared_distance(box, center); }, most2,
      [&](int i) {
        Nearest one{infinity, -1, Vector3::Zero(), {1, 0, 0}};
        look_at(i, center, one);
        if (one.squared > most2) return;
        candidates_.push_back({i, static_cast<float>(just_below * std::sqrt(one.squared))});
      });
  std::sort(candidates_.begin() + first, candidates_.end(),
            [](const Candidate& a, const Candidate& b) {
              return a.least < b.least || (a.least == b.least && a.face < b.face);
            });
}

double Solid::thickness_below(std::size_t face) const {
  const Corners& corners = corners_[face];
  const Vector3 in = -faces_[face].normal;
  const Vector3 from = (corners[0] + corners[1] + corners[2]) / 3 + smallest_gap * radius_ * in;
  double least = std::numeric_limits<double>::max();  // boxes off the ray are farther
  face_tree_.search([&](const Box& box) { return hit_by_ray(from, in, box); }, least,
                    [&](int i) {
                      if (static_cast<std::size_t>(i) == face) return;
                      least = std::min(least,
                                       hit_by_ray(from, in, corners_[static_cast<std::size_t>(i)]));
                    });
  return least;
}

double Solid::measure_thickness() const {
  const std::size_t every = (faces_.size() + most_measured - 1) / most_measured;
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
