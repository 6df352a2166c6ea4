#include "clothsim/geometry/panel_side.h"

#include <Eigen/Geometry>
#include <cmath>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Segments of a curve between two of its points.
constexpr int segments = 64;

}  // namespace

std::string place_text(const PlanePoint& p) {
  return '[' + to_text(p.x()) + ", " + to_text(p.y()) + ']';
}

PanelSide straight_side(const PlanePoint& from, const PlanePoint& to) { return {from, to}; }

PanelSide arc_side(const PlanePoint& from, const PlanePoint& through, const PlanePoint& to) {
  const PlanePoint b = through - from, c = to - from;
  const double twice = 2 * cross(b, c);
  if (std::abs(twice) <= 1e-6 * b.norm() * c.norm()) {
    throw InvalidValue({}, place_text(through) + ", on the line through the corners",
                       "a point beside the line");
  }
  const PlanePoint offset(c.y() * b.squaredNorm() - b.y() * c.squaredNorm(),
                          b.x() * c.squaredNorm() - c.x() * b.squaredNorm());
  const PlanePoint center = from + offset / twice;
  const auto angle = [&](const PlanePoint& p) {
    return std::atan2(p.y() - center.y(), p.x() - center.x());
  };
  // Anticlockwise where `through` is to the right of the line.
  const double turn = twice > 0 ? 1 : -1;
  const double sweep = std::fmod(turn * (angle(to) - angle(from)) + 4 * M_PI, 2 * M_PI);
  PanelSide side{from};
  for (int k = 1; k < segments; ++k) {
    const double at = angle(from) + turn * sweep * k / segments;
    side.push_back(center +
                   offset.norm() / std::abs(twice) * PlanePoint(std::cos(at), std::sin(at)));
  }
  side.push_back(to);
  return side;
}

PanelSide curved_side(const PlanePoint& from, const std::vector<PlanePoint>& through,
                      const PlanePoint& to) {
  std::vector<PlanePoint> knots{from};
  knots.insert(knots.end(), through.begin(), through.end());
  knots.push_back(to);
  knots.insert(knots.begin(), 2 * knots[0] - knots[1]);
  knots.push_back(2 * knots.back() - knots[knots.size() - 2]);
  PanelSide side{from};
  for (std::size_t i = 1; i + 2 < knots.size(); ++i) {
    const PlanePoint &a = knots[i - 1], &b = knots[i], &c = knots[i + 1], &d = knots[i + 2];
    for (int k = 1; k <= segments; ++k) {
      const double t = double(k) / segments;
      side.push_back(b +
                     t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a))));
    }
  }
  side.back() = to;
  return side;
}

double length_of(const PanelSide& side) {
  double length = 0;
  for (std::size_t i = 1; i < side.size(); ++i) length += (side[i] - side[i - 1]).norm();
  return length;
}

std::vector<PlanePoint> points_along(const PanelSide& side, int count) {
  const double step = length_of(side) / count;
  std::vector<PlanePoint> points{side.front()};
  double passed = 0;  // length up to the segment
  for (std::size_t i = 1; i < side.size(); ++i) {
    const double length = (side[i] - side[i - 1]).norm();
    while (static_cast<int>(points.size()) < count &&
           step * double(points.size()) <= passed + length) {
      const double share = (step * double(points.size()) - passed) / length;
      points.push_back(side[i - 1] + share * (side[i] - side[i - 1]));
    }
    passed += length;
  }
  points.push_back(side.back());
  return points;
}

}  // namespace clothsim
