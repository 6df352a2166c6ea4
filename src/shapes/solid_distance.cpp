// The triangle of a solid that is nearest to a point.

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {
namespace {

/// Grid cells per triangle: about two along a triangle's edge, near the surface. At least enough
/// for a box, and at most 16 MB of them.
constexpr double cells_by_triangle = 64;
constexpr double fewest_cells = 4096;
constexpr double max_cells = 4e6;

/// Cells have a list of candidates up to this distance from the surface and half a cell: more than
/// the gap of points in contact with a smooth solid [m], but at most two cells, as a fine mesh has
/// many.
constexpr double widest_band = 2e-3;
constexpr double band_cells = 2;

/// A neighbourhood moves to a point that is farther from its place, by the point's distance from
/// the surface.
constexpr double most_moved = 0.05;

/// Factor from a distance rounded to float to a lower bound of it.
constexpr double just_below = 1 - 1e-6;

}  // namespace

/// The nearest of the triangles added, sorted, and one more that bounds the distance of the others.
class Solid::NearestFew {
 public:
  void add(const Nearest& one) {
    std::size_t i = found_.size() - 1;
    if (!one.is_before(found_[i])) return;
    for (; i > 0 && one.is_before(found_[i - 1]); --i) found_[i] = found_[i - 1];
    found_[i] = one;
    most_ = std::sqrt(found_.back().squared);
  }

  /// Triangles farther away than this need not be added [m].
  const double& most() const { return most_; }
  const Nearest& first() const { return found_[0]; }

  /// `unseen`: lower bound on the distance of the triangles that were not added [m].
  void store(const Vector3& place, double unseen, Neighbourhood& result) const {
    result.place = place;
    result.outside = 0;
    result.beyond = std::min(most_, unseen);
    for (result.count = 0; result.count < Neighbourhood::most; ++result.count) {
      if (found_[result.count].face < 0) break;
      result.faces[result.count] = found_[result.count].face;
      result.distances[result.count] = std::sqrt(found_[result.count].squared);
    }
  }

 private:
  std::array<Nearest, Neighbourhood::most + 1> found_;
  double most_ = infinity;
};

Solid::Nearest Solid::look_at(int index, const Vector3& point) const {
  const auto& [a, b, c] = corners_[static_cast<std::size_t>(index)];
  const std::array<double, 3> w = closest_on_triangle(point, a, b, c);
  const Vector3 gap = point - (w[0] * a + w[1] * b + w[2] * c);
  return {gap.squaredNorm(), index, gap, w};
}

Solid::Nearest Solid::nearest_by_tree(const Vector3& point, double most) const {
  Nearest nearest;
  double most2 = most * most;
  face_tree_.search([&](const Box& box) { return squared_distance(box, point); }, most2,
                    [&](int i) {
                      const Nearest one = look_at(i, point);
                      if (one.is_before(nearest)) nearest = one;
                      most2 = std::min(most2, nearest.squared);
                    });
  return nearest;
}

/// Calls visit(face) for the candidates of a cell that may be within `most` [m] of a point of it;
/// `visit` may lower `most`.
template <class Visit>
void Solid::visit_candidates(int cell, const Vector3& point, const double& most,
                             const Visit& visit) const {
  const double off = (point - center_of(cell)).norm();
  const Eigen::Vector3f at = point.cast<float>();
  const int end = first_of_[static_cast<std::size_t>(cell) + 1];
  for (int i = first_of_[static_cast<std::size_t>(cell)]; i < end; ++i) {
    const Candidate& candidate = candidates_[static_cast<std::size_t>(i)];
    if (candidate.least - off > most) break;
    const Ball& ball = balls_[static_cast<std::size_t>(candidate.face)];
    const float x = at.x() - ball.x, y = at.y() - ball.y, z = at.z() - ball.z;
    const float reach = static_cast<float>(most) + ball.radius;
    if (x * x + y * y + z * z <= reach * reach) visit(candidate.face);
  }
}

Vector3 Solid::normal_at(const Nearest& nearest) const {
  const auto face = static_cast<std::size_t>(nearest.face);
  const std::array<double, 3>& w = nearest.weights;
  for (std::size_t k = 0; k < 3; ++k) {
    if (w[k] >= 1 - smallest) return vertex_normals_[static_cast<std::size_t>(triangles_[face][k])];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (w[(k + 2) % 3] <= smallest) return faces_[face].edge_normals[k];
  }
  return faces_[face].normal;
}

std::pair<double, Vector3> Solid::distance(const Vector3& point) const {
  const int cell = cell_of(point);
  if (cell < 0 || !has_candidates(static_cast<std::size_t>(cell))) {
    return signed_distance(nearest_by_tree(point, infinity));
  }
  Nearest nearest;
  double most = infinity;
  visit_candidates(cell, point, most, [&](int face) {
    const Nearest one = look_at(face, point);
    if (!one.is_before(nearest)) return;
    nearest = one;
    most = std::sqrt(one.squared);
  });
  return signed_distance(nearest);
}

std::pair<double, Vector3> Solid::signed_distance(const Nearest& nearest) const {
  const Vector3 normal = normal_at(nearest);
  const double value = std::sqrt(nearest.squared);
  const double sign = !is_sheet_ && nearest.gap.dot(normal) < 0 ? -1 : 1;
  if (value > smallest * radius_) return {sign * value, sign / value * nearest.gap};
  const Vector3 unit = normal.stableNormalized();
  return {sign * value, unit.isZero(0) ? Vector3::UnitZ() : unit};
}

/// The nearest triangle, where it is known to be one of a neighbourhood; else `face` is -1.
Solid::Nearest Solid::nearest_of(Neighbourhood& kept, const Vector3& point, double moved) const {
  Nearest nearest;
  const double beyond = kept.beyond - moved;
  if (!(beyond > 0)) return nearest;
  std::size_t looked = 0;
  for (; looked < kept.count; ++looked) {
    const double far = kept.distances[looked] - moved;
    if (far > 0 && far * far > nearest.squared) break;
    const Nearest one = look_at(kept.faces[looked], point);
    if (one.is_before(nearest)) nearest = one;
  }
  if (!(nearest.squared < beyond * beyond)) return {};
  // Far from the place of the neighbourhood one triangle does not suffice.
  if (looked > 1 && moved * moved > most_moved * most_moved * nearest.squared) {
    NearestFew few;
    for (std::size_t i = 0; i < kept.count; ++i) few.add(look_at(kept.faces[i], point));
    few.store(point, beyond, kept);
  }
  return nearest;
}

std::pair<double, Vector3> Solid::distance_within(double near, const Vector3& point,
                                                  Neighbourhood& kept) const {
  const double moved = (point - kept.place).norm() + smallest * radius_;
  if (kept.outside - moved >= near) return {kept.outside - moved, Vector3::UnitZ()};
  const Nearest nearest = nearest_of(kept, point, moved);
  if (nearest.face >= 0) {
    const auto result = signed_distance(nearest);
    if (kept.place == point) kept.outside = std::max(0.0, result.first);
    return result;
  }

  const int cell = cell_of(point);
  double least = 0;
  if (cell < 0) {
    least = std::sqrt(squared_distance(box_, point));
  } else if (const int steps = steps_[static_cast<std::size_t>(cell)]; steps > 0) {
    // Every point within the band of the surface lies in a cell with candidates.
    least = band() + (steps - 1) * cell_;
  }
  const double beyond = kept.beyond - moved;
  if (least > 0) least = std::max(least, beyond);
  if (least >= near) return {least, Vector3::UnitZ()};

  NearestFew few;
  if (cell >= 0 && has_candidates(static_cast<std::size_t>(cell))) {
    visit_candidates(cell, point, few.most(), [&](int face) { few.add(look_at(face, point)); });
    few.store(point, beyond_candidates(cell, point), kept);
  } else {
    // Inside the solid the nearest triangle counts at any distance.
    const double most = least > 0 ? 1.5 * near : infinity;
    double most2 = most * most;
    face_tree_.search([&](const Box& box) { return squared_distance(box, point); }, most2,
                      [&](int i) {
                        few.add(look_at(i, point));
                        most2 = std::min(most2, few.most() * few.most());
                      });
    few.store(point, most, kept);
    if (few.first().squared > most * most) {
      kept.outside = most;
      return {most, Vector3::UnitZ()};
    }
  }
  const auto result = signed_distance(few.first());
  kept.outside = std::max(0.0, result.first);
  return result;
}

double Solid::beyond_candidates(int cell, const Vector3& point) const {
  const Candidate& first =
      candidates_[static_cast<std::size_t>(first_of_[static_cast<std::size_t>(cell)])];
  return first.least + just_below * std::sqrt(3.0) * cell_ - (point - center_of(cell)).norm();
}

/// Two sweeps over the grid, from either end, find each shortest way (Rosenfeld & Pfaltz 1968).
void Solid::count_steps() {
  const auto [nx, ny, nz] = cells_;
  const auto index = [&](int x, int y, int z) {
    return static_cast<std::size_t>((z * ny + y) * nx + x);
  };
  constexpr unsigned char most = std::numeric_limits<unsigned char>::max();
  steps_.assign(first_of_.size() - 1, most);
  const auto look = [&](int x, int y, int z, int back) {
    const std::size_t here = index(x, y, z);
    int steps = has_candidates(here) ? 0 : steps_[here];
    // The neighbours that this sweep has passed.
    for (int i = 0; i < 13 && steps > 0; ++i) {
      const int ox = x + back * (i % 3 - 1), oy = y + back * (i / 3 % 3 - 1);
      const int oz = z + back * (i / 9 - 1);
      if (ox < 0 || ox >= nx || oy < 0 || oy >= ny || oz < 0 || oz >= nz) continue;
      steps = std::min(steps, steps_[index(ox, oy, oz)] + 1);
    }
    steps_[here] = static_cast<unsigned char>(steps);
  };
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) look(x, y, z, 1);
  for (int z = nz; z-- > 0;)
    for (int y = ny; y-- > 0;)
      for (int x = nx; x-- > 0;) look(x, y, z, -1);
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
  // Rounding of coordinates as large as the solid, and of a distance.
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
      std::clamp(cells_by_triangle * static_cast<double>(faces_.size()), fewest_cells, max_cells);
  // A flat solid gets as many cells as a cube.
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
  count_steps();
  if (!is_sheet_) forget_steps_inside();
}

/// Neighbours without candidates are on the same side: there is no surface between them.
void Solid::forget_steps_inside() {
  const std::array<std::size_t, 3> to_last = {
      1, static_cast<std::size_t>(cells_[0]),
      static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1])};
  for (std::size_t cell = 0; cell < steps_.size(); ++cell) {
    if (has_candidates(cell)) continue;
    std::size_t place = cell;
    bool is_known = false, is_inside = false;
    for (std::size_t axis = 0; axis < 3 && !is_known; ++axis) {
      const auto along = static_cast<std::size_t>(cells_[axis]);
      const std::size_t last = cell - to_last[axis];
      is_known = place % along > 0 && !has_candidates(last);
      if (is_known) is_inside = steps_[last] == 0;
      place /= along;
    }
    if (!is_known) is_inside = distance(center_of(static_cast<int>(cell))).first < 0;
    if (is_inside) steps_[cell] = 0;
  }
}

/// By cell: whether the box of a triangle comes within `reach` [m] of the cell.
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
  // A point of the cell is within half a diagonal of the centre; its distance from any triangle
  // differs by no more than that.
  const double most = std::sqrt(nearest.squared) + 2 * half;
  double most2 = most * most;
  const auto first = static_cast<std::ptrdiff_t>(candidates_.size());
  face_tree_.search(
      [&](const Box& box) { return squared_distance(box, center); }, most2,
      [&](int i) {
        const Nearest one = look_at(i, center);
        if (one.squared > most2) return;
        candidates_.push_back({i, static_cast<float>(just_below * std::sqrt(one.squared))});
      });
  std::sort(candidates_.begin() + first, candidates_.end(),
            [](const Candidate& a, const Candidate& b) {
              return a.least < b.least || (a.least == b.least && a.face < b.face);
            });
}

}  // namespace clothsim
