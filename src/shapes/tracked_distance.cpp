#include "clothsim/shapes/tracked_distance.h"

#include <algorithm>

#include "shape_parts.h"

namespace clothsim {
namespace {

/// Most places that a search measures: more take as long as a search without a start.
constexpr int max_places = 4;

template <class AnyShape>
class Tracker {
 public:
  Tracker(const AnyShape& shape, const Triangle& t) : shape_(shape), t_(t) {}

  std::optional<FaceDistance> from(const Weights& start) const {
    const auto zeros = std::count(start.begin(), start.end(), 0.0);
    if (zeros == 2) return on_corner(start);
    if (zeros == 0) return on_face();
    const auto opposite = std::find(start.begin(), start.end(), 0.0) - start.begin();
    const std::size_t i = (static_cast<std::size_t>(opposite) + 1) % 3;
    return along_edge(i, start[(i + 1) % 3]);
  }

 private:
  FaceDistance measure(const Weights& w) const {
    const Vector3 p = at(t_, w);
    const Distance d = shape_.near_surface(p.x(), p.y(), p.z(), 0);
    return {d.value, d.normal, w};
  }

  std::optional<FaceDistance> on_corner(const Weights& w) const {
    const FaceDistance found = measure(w);
    if (is_only_nearest(found, t_)) return found;
    return std::nullopt;
  }

  std::optional<FaceDistance> if_separating(const FaceDistance& found) const {
    if (is_separating(found, t_)) return found;
    return std::nullopt;
  }

  /// Secants of the slope of half the squared distance along the edge from corner i, from the share
  /// s on.
  std::optional<FaceDistance> along_edge(std::size_t i, double s) const {
    const Vector3 along = edge(t_, i);
    const double flat = turn_tolerance * along.norm();
    double rise = along.squaredNorm();  // of the slope by s; at most so where the shape is straight
    double last_s = 0, last_slope = 0;
    for (int step = 0; step < max_places && s > 0 && s < 1; ++step) {
      const FaceDistance found = measure(on_edge(i, s));
      if (found.value <= 0) break;
      const double turn = found.normal.dot(along), slope = turn * found.value;
      if (std::abs(turn) <= flat) return if_separating(found);
      if (step > 0) rise = (slope - last_slope) / (s - last_s);
      last_s = s;
      last_slope = slope;
      s -= slope / rise;
    }
    return std::nullopt;
  }

  /// The face against the shape's point that is nearest to its plane.
  std::optional<FaceDistance> on_face() const {
    Vector3 n = unit_normal(t_);
    if (n.dot(t_[0]) < 0) n = -n;  // the shape is about the origin
    const Vector3 nearest = shape_.support(n);
    const double value = n.dot(t_[0] - nearest);
    const Weights w = closest_on_triangle(nearest, t_[0], t_[1], t_[2]);
    const bool inside = *std::min_element(w.begin(), w.end()) > 0;
    if (!inside || value <= 0) return std::nullopt;
    return FaceDistance{value, n, w};
  }

  const AnyShape& shape_;
  const Triangle& t_;
};

}  // namespace

std::optional<FaceDistance> tracked_distance(const Shape& shape, const Triangle& t,
                                             const std::array<double, 3>& start) {
  return std::visit(
      [&](const auto& s) -> std::optional<FaceDistance> {
        using AnyShape = std::decay_t<decltype(s)>;
        if constexpr (is_convex_solid_v<AnyShape>) return Tracker<AnyShape>(s, t).from(start);
        return std::nullopt;
      },
      shape);
}

}  // namespace clothsim
