#include "clothsim/shapes/cylinder.h"

#include <algorithm>

#include "shape_parts.h"

namespace clothsim {
namespace {

/// Share of an edge in which a search for its nearest point ends at last.
constexpr double narrowest = 1e-12;

/// Most steps of a search by Newton's method or secants: beside a kink bisection is faster.
constexpr int max_steps = 20;

/// A place on an edge, and its distance.
struct OnEdge {
  double s;  // from corner i to i + 1
  Distance distance;
};

Distance distance_at(const Cylinder& cylinder, const Vector3& p) {
  return cylinder.near_surface(p.x(), p.y(), p.z(), 0);
}

/// Half of the second derivative along `u` of the squared distance from the solid, at a point out
/// of it.
double half_second_derivative(const Cylinder& cylinder, const Vector3& p, const Vector3& u) {
  const double r = p.head<2>().norm(), over = r - cylinder.radius;
  double sum = std::abs(p.z()) > cylinder.length / 2 ? u.z() * u.z() : 0;
  if (over <= 0) return sum;
  const double away = p.head<2>().dot(u.head<2>()) / r;
  return sum + away * away + over / r * (u.head<2>().squaredNorm() - away * away);
}

/// The place with the least distance on the edge from a to b, whose distances are known and
/// positive, or one in the solid; empty where all are above `limit`. The distance is convex: its
/// slope has one sign change, to which Newton's steps for the squared distance lead within a
/// bracket, and it is nowhere below its tangents.
std::optional<OnEdge> min_on_edge(const Cylinder& cylinder, const Vector3& a, const Distance& at_a,
                                  const Vector3& b, const Distance& at_b, double limit) {
  const Vector3 along = b - a;
  const double flat = turn_tolerance * along.norm();
  const auto slope = [&](const OnEdge& x) { return x.distance.normal.dot(along); };
  OnEdge low{0, at_a}, high{1, at_b};
  double down = slope(low), up = slope(high);
  if (down >= 0) return low;
  if (up <= 0) return high;
  const double falls = down * low.distance.value;
  double s = falls / (falls - up * high.distance.value);  // as if it were a parabola
  for (int step = 0; high.s - low.s > narrowest; ++step) {
    const double width = high.s - low.s;
    const double rise = high.distance.value - low.distance.value;
    const double least = low.distance.value + down * (up * width - rise) / (up - down);
    if (least > limit) return std::nullopt;
    const Vector3 p = a + s * along;
    const OnEdge middle{s, distance_at(cylinder, p)};
    const double now = slope(middle);
    if (middle.distance.value <= 0 || std::abs(now) <= flat) return middle;
    (now < 0 ? low : high) = middle;
    (now < 0 ? down : up) = now;
    s -= middle.distance.value * now / half_second_derivative(cylinder, p, along);
    if (step > max_steps || !(s > low.s && s < high.s)) s = (low.s + high.s) / 2;
  }
  return low.distance.value < high.distance.value ? low : high;
}

/// Does the solid reach through the inside of the triangle, given that the triangle's edges are out
/// of it? Then the solid's section with the plane lies in the triangle, or all of it outside.
bool reaches_through(const Cylinder& cylinder, const Triangle& t, const Vector3& n) {
  if (n.isZero(0)) return false;
  const Vector3 above = cylinder.support(n), below = cylinder.support(-n);
  const double high = n.dot(above - t[0]), low = n.dot(below - t[0]);
  if (high <= 0 || low >= 0) return false;
  const Vector3 p = below + low / (low - high) * (above - below);
  for (std::size_t i = 0; i < 3; ++i) {
    if (n.dot(edge(t, i).cross(p - t[i])) < 0) return false;
  }
  return true;
}

/// Directions around an edge at which the search for the shortest way out starts: the length of the
/// way is a support function in the plane across the edge, with up to four minima.
constexpr int tried = 24;

/// Cosines and sines of the angles of these directions.
const std::array<Eigen::Vector2d, tried>& tried_directions() {
  static const auto directions = [] {
    std::array<Eigen::Vector2d, tried> result;
    for (int k = 0; k < tried; ++k) {
      const double angle = 2 * M_PI * k / tried;
      result[static_cast<std::size_t>(k)] = {std::cos(angle), std::sin(angle)};
    }
    return result;
  }();
  return directions;
}

/// A direction, unit, and the point that lies farthest along it of all vectors from the triangle to
/// the cylinder: a triangle that moves out that way moves by their product.
struct Way {
  Vector3 out, farthest;

  double length() const { return farthest.dot(out); }
};

class CylinderExit {
 public:
  CylinderExit(const Cylinder& cylinder, const Triangle& t) : cylinder_(cylinder), t_(t) {}

  /// `on`: an edge perpendicular to `out`, if any.
  void add(const Vector3& out, std::optional<std::size_t> on) {
    const double depth = way(out).length();
    if (depth >= exit_.shortest().value) return;
    const std::size_t low = lowest(t_, out);
    Weights weights = corner(low);
    const Vector3 p = cylinder_.support(out);
    if (on && is_end(low, *on)) {
      const Vector3 e = edge(t_, *on);
      const double s = e.isZero(0) ? 0 : (p - t_[*on]).dot(e) / e.squaredNorm();
      weights = on_edge(*on, std::clamp(s, 0.0, 1.0));
    } else if (!on) {
      weights = closest_on_triangle(p, t_[0], t_[1], t_[2]);
    }
    exit_.add(depth, out, weights);
  }

  /// Adds the shortest way perpendicular to an edge.
  void add_across(std::size_t i) {
    const Vector3 e = edge(t_, i);
    if (e.isZero(0)) return;
    const Vector3 axis = e.normalized(), u = axis.unitOrthogonal(), v = axis.cross(u);
    std::array<Way, tried> ways;
    std::transform(tried_directions().begin(), tried_directions().end(), ways.begin(),
                   [&](const auto& d) { return way(d[0] * u + d[1] * v); });
    for (std::size_t k = 0; k < tried; ++k) {
      const Way &before = ways[(k + tried - 1) % tried], &after = ways[(k + 1) % tried];
      const Way& here = ways[k];
      if (here.length() > after.length() || here.length() > before.length()) continue;
      // No way between both is shorter than one of them to this point.
      const double bound = std::min(here.farthest.dot(before.out), here.farthest.dot(after.out));
      if (bound < exit_.shortest().value) add(shortest_between(before, here, after, axis), i);
    }
  }

  const FaceDistance& shortest() const { return exit_.shortest(); }

 private:
  Way way(const Vector3& out) const { return {out, cylinder_.support(out) - t_[lowest(t_, out)]}; }

  /// The direction of the shortest way among those that turn about `axis` from `low` to `high`,
  /// between which `middle` is shorter than both. The length is the greatest of the products of
  /// the direction with all points, and has its minimum where two of them are equal, or where its
  /// slope is 0. By turns the products of both ends' points lead to the former, and their secant
  /// to the latter.
  Vector3 shortest_between(Way low, const Way& middle, Way high, const Vector3& axis) const {
    const auto slope = [&](const Way& w) { return axis.cross(w.out).dot(w.farthest); };
    (slope(middle) < 0 ? low : high) = middle;
    const double precise = parallel * (cylinder_.radius + cylinder_.length);
    for (int step = 0;; ++step) {
      Vector3 out = axis.cross(low.farthest - high.farthest).normalized();
      if (out.dot(low.out) < 0) out = -out;
      const bool is_between = axis.cross(low.out).dot(out) > 0 && axis.cross(out).dot(high.out) > 0;
      const double bound = is_between ? out.dot(low.farthest) : 0;
      const Way& best = low.length() < high.length() ? low : high;
      const double width = axis.cross(low.out).dot(high.out);
      if (best.length() - bound < precise || width < std::sqrt(parallel)) return best.out;
      const bool bisects = !is_between || step > max_steps, by_secant = step % 2 == 1;
      if (bisects || by_secant) {
        const double down = slope(low), up = slope(high);
        const double share = !bisects && down < 0 && up > 0 ? down / (down - up) : 0.5;
        out = ((1 - share) * low.out + share * high.out).normalized();
      }
      const Way next = way(out);
      (slope(next) < 0 ? low : high) = next;
    }
  }

  const Cylinder& cylinder_;
  const Triangle& t_;
  ShortestExit exit_;
};

/// The shortest way out: along the axis, along the triangle's normal, straight away from the axis
/// at a corner, or perpendicular to an edge.
FaceDistance shortest_exit(const Cylinder& cylinder, const Triangle& t, const Vector3& n) {
  CylinderExit exit(cylinder, t);
  for (const double sign : {-1.0, 1.0}) {
    const Vector3 along = sign * Vector3::UnitZ();
    exit.add(along, {});
    if (!n.isZero(0)) exit.add(sign * n, {});
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 across = along.cross(edge(t, i));
      if (across.norm() > std::sqrt(parallel) * edge(t, i).norm()) exit.add(across.normalized(), i);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 away(t[i].x(), t[i].y(), 0);
    exit.add(away.isZero(0) ? Vector3::UnitX() : away.normalized(), {});
    exit.add_across(i);
  }
  return exit.shortest();
}

}  // namespace

Vector3 Cylinder::support(const Vector3& direction) const {
  const Vector3 across(direction.x(), direction.y(), 0);
  const double slope = across.norm();
  Vector3 p = slope > 0 ? Vector3(radius / slope * across) : Vector3(0, 0, 0);
  if (direction.z() != 0) p.z() = direction.z() < 0 ? -length / 2 : length / 2;
  return p;
}

std::optional<double> Cylinder::entry(const Vector3& from, const Vector3& displacement,
                                      double offset) const {
  double in = 0, out = infinity;
  const auto keep_within = [&](double first, double last) {
    in = std::max(in, first);
    out = std::min(out, last);
  };
  const double half = length / 2 + offset, kept = radius + offset;
  if (displacement.z() != 0) {
    const double a = (-half - from.z()) / displacement.z(),
                 b = (half - from.z()) / displacement.z();
    keep_within(std::min(a, b), std::max(a, b));
  } else if (std::abs(from.z()) > half) {
    return std::nullopt;
  }
  const Eigen::Vector2d from2 = from.head<2>(), along2 = displacement.head<2>();
  const double a = along2.squaredNorm(), b = from2.dot(along2),
               c = from2.squaredNorm() - kept * kept;
  const double discriminant = b * b - a * c;
  if (a > 0 && discriminant >= 0) {
    const double root = std::sqrt(discriminant);
    keep_within((-b - root) / a, (-b + root) / a);
  } else if (c > 0) {
    return std::nullopt;
  }
  if (in > out) return std::nullopt;
  return in;
}

std::optional<FaceDistance> Cylinder::face_distance(const Triangle& t, double reach) const {
  if (outside(box_of(t), {radius, radius, length / 2}) > reach) return std::nullopt;

  const std::array<Distance, 3> corners{distance_at(*this, t[0]), distance_at(*this, t[1]),
                                        distance_at(*this, t[2])};
  if (min_distance(t, corners) > reach) return std::nullopt;
  FaceDistance nearest = nearest_corner(corners);
  for (std::size_t i = 0; i < 3 && nearest.value > 0 && !is_separating(nearest, t); ++i) {
    const std::size_t j = (i + 1) % 3;
    const double limit = std::min(reach, nearest.value);
    const auto on = min_on_edge(*this, t[i], corners[i], t[j], corners[j], limit);
    if (!on || on->distance.value >= nearest.value) continue;
    nearest = {on->distance.value, on->distance.normal, on_edge(i, on->s)};
  }
  if (is_separating(nearest, t)) return within(reach, nearest);
  const Vector3 n = unit_normal(t);
  if (nearest.value <= 0 || reaches_through(*this, t, n)) {
    FaceDistance exit = shortest_exit(*this, t, n);
    exit.value = std::min(-exit.value, 0.0);
    return exit;
  }
  // The solid's point nearest to the plane, where that is over the triangle's inside.
  if (!n.isZero(0)) {
    const Vector3 p = support(n.dot(t[0]) > 0 ? n : Vector3(-n));
    Closest inside;
    inside.add(p, t, closest_on_triangle(p, t[0], t[1], t[2]));
    if (inside.least() > 0 && inside.least() < nearest.value) nearest = inside.result();
  }
  return within(reach, nearest);
}

void Cylinder::visit_lines(const Triangle&, const Vector3& normal, double,
                           const VisitLine& visit) const {
  const Vector3 up(0, 0, length / 2);
  const Eigen::Vector2d across = normal.head<2>();
  const double slope = across.norm();
  if (slope > std::abs(normal.z())) {  // its side, along the axis
    const Vector3 out = radius / slope * Vector3(across.x(), across.y(), 0);
    visit(Vector3(out - up), Vector3(out + up), 0);
    return;
  }
  // An end: two of its diameters.
  const Vector3 end = normal.z() < 0 ? Vector3(-up) : up;
  for (const int axis : {0, 1}) {
    const Vector3 out = radius * Vector3::Unit(axis);
    visit(Vector3(end - out), Vector3(end + out), 0);
  }
}

/// Does `box` reach into the cylinder, or come within `reach` of its side or of the rim of an end?
bool Cylinder::may_touch(const Box& box, const Triangle*, double reach) const {
  if (outside(box, {radius, radius, length / 2}) > reach) return false;
  const bool beyond_end = box.min().z() > length / 2 || box.max().z() < -length / 2;
  const Eigen::Vector2d farthest = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).head<2>();
  return !beyond_end || farthest.norm() + reach >= radius;
}

}  // namespace clothsim
