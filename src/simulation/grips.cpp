#include "clothsim/simulation/grips.h"

#include <algorithm>
#include <limits>
#include <set>

#include "clothsim/model/checks.h"
#include "clothsim/scene/scene.h"

namespace clothsim {
namespace {

constexpr Range tear_force_range{0, 1e12, "N"};
constexpr Range radius_range{0, 1e6, "m"};

/// A spring's pull on its end `at`, the other end being at `to` [N].
Vector3 pull(const SpringRun& run, const Vector3& at, const Vector3& to) {
  const Vector3 d = to - at;
  const double length = d.norm();
  if (length == 0) return Vector3::Zero();
  return run.stiffness * (length - run.rest_length) / length * d;
}

/// What pairs of a fabric do to a point [N].
Vector3 pull_of_pairs(const Cloth& cloth, const State& state, int i) {
  Vector3 force = Vector3::Zero();
  for (const PairBand& band : cloth.pairs) {
    for (const int first : {i, i - band.offset}) {
      if (first < 0 || first >= static_cast<int>(band.bend.size())) continue;
      const int other = first == i ? i + band.offset : first;
      const Vector3 d = row(state.positions, other) - row(state.positions, i);
      const Vector3 rate = row(state.velocities, other) - row(state.velocities, i);
      force += band.bend[first] * (d + cloth.internal_damping[1] * rate);
      if (band.spring.size() == 0 || d.norm() == 0) continue;
      const Vector3 u = d.normalized();
      force += band.spring[first] *
               (d.norm() - band.rest_length + cloth.internal_damping[0] * u.dot(rate)) * u;
    }
  }
  return force;
}

}  // namespace

std::vector<int> free_points_near(const Cloth& cloth, const Points& positions,
                                  const Vector3& position, double radius) {
  check_range("radius", radius, radius_range);
  std::vector<int> free;
  bool is_any_held = false;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if ((row(positions, i) - position).norm() > radius) continue;
    const bool is_held = cloth.inv_mass[i] == 0;
    is_any_held = is_any_held || is_held;
    if (!is_held) free.push_back(i);
  }
  if (free.empty()) {
    throw InvalidValue(
        {"radius"},
        to_text(radius) + (is_any_held ? " with none but points inside that are held already"
                                       : " with no point inside"),
        "one about a free point of the cloth");
  }
  return free;
}

void Grips::attach(const std::string& frame, const Pose& pose, const std::vector<int>& points,
                   std::optional<double> tear_force, const Cloth& cloth, const Points& positions) {
  if (tear_force) check_range("tear_force", *tear_force, tear_force_range);
  if (points.empty()) throw InvalidValue({"points"}, "none", "one or more");
  std::set<int> given;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int point = points[i];
    const auto refuse = [&](const std::string& what, const std::string& expected) {
      throw InvalidValue({"points", std::to_string(i)}, std::to_string(point) + what, expected);
    };
    if (point < 0 || point >= cloth.num_points()) {
      refuse("", "a number from 0 to " + std::to_string(cloth.num_points() - 1));
    }
    if (cloth.inv_mass[point] == 0) refuse(", which is held already", "a point that is free");
    if (!given.insert(point).second) refuse(" again", "each point once");
  }

  Grip& grip = all_[frame];
  grip.pose = pose;
  grip.tear_force = tear_force;
  for (const int point : points) {
    const Vector3 position = positions.row(point).transpose();
    grip.held.push_back({point, pose.orientation.conjugate() * (position - pose.position)});
  }
}

void Grips::detach(const std::vector<int>& points) {
  std::set<int> attached;
  for (const auto& [frame, grip] : all_) {
    for (const Grip::Held& held : grip.held) attached.insert(held.point);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (attached.count(points[i]) == 0) {
      throw InvalidValue({"points", std::to_string(i)}, std::to_string(points[i]),
                         "a point that is attached");
    }
  }

  const std::set<int> free(points.begin(), points.end());
  for (auto entry = all_.begin(); entry != all_.end();) {
    std::vector<Grip::Held>& held = entry->second.held;
    held.erase(std::remove_if(held.begin(), held.end(),
                              [&](const Grip::Held& h) { return free.count(h.point) > 0; }),
               held.end());
    entry = held.empty() ? all_.erase(entry) : std::next(entry);
  }
}

void Grips::hold(Cloth& cloth) const {
  for (const auto& [frame, grip] : all_) {
    for (const Grip::Held& held : grip.held) cloth.inv_mass[held.point] = 0;
  }
}

void Grips::set_out(double dt, State& state) const {
  for (const auto& [frame, grip] : all_) {
    for (const Grip::Held& held : grip.held) {
      const Vector3 way = place(grip, held) - state.positions.row(held.point).transpose();
      state.velocities.row(held.point) = way.transpose() / dt;
    }
  }
}

void arrive_at(const Vector3& target, int point, const State& before, State& state) {
  // Of the largest numbers, as much as so many steps make.
  constexpr double rounding = max_substeps * std::numeric_limits<double>::epsilon();
  const double scale = std::max({1.0, target.norm(), before.positions.row(point).norm()});
  if ((state.positions.row(point).transpose() - target).norm() > rounding * scale) return;
  state.positions.row(point) = target.transpose();
}

void Grips::arrive(const State& before, State& state) const {
  for (const auto& [frame, grip] : all_) {
    for (const Grip::Held& held : grip.held) {
      arrive_at(place(grip, held), held.point, before, state);
    }
  }
}

/// What its neighbours do to a held point, its weight and its drag pass on to the frame, which
/// gives it its acceleration: F = sum of p / dt + m (g - c v - dv / dt).
void Grips::weigh(const Cloth& cloth, const Vector3& gravity, double dt, const Points& impulses,
                  const State& before, const State& after) {
  for (auto& [frame, grip] : all_) {
    grip.wrench = {};
    for (const Grip::Held& held : grip.held) {
      const int i = held.point;
      const Vector3 v = after.velocities.row(i).transpose();
      const Vector3 acceleration = (v - before.velocities.row(i).transpose()) / dt;
      const Vector3 own = cloth.mass[i] * (gravity - cloth.damping * v - acceleration);
      const Vector3 force = impulses.row(i).transpose() / dt + own;
      const Vector3 arm = after.positions.row(i).transpose() - grip.pose.position;
      grip.wrench.add(arm, force);
    }
  }
}

void Grips::add_spring_impulses(const Cloth& cloth, double h, const State& state,
                                Points& impulses) const {
  for (const auto& [frame, grip] : all_) {
    for (const Grip::Held& held : grip.held) {
      const int i = held.point;
      if (!cloth.pairs.empty()) {
        impulses.row(i) += h * pull_of_pairs(cloth, state, i).transpose();
        continue;
      }
      for (const SpringRun& run : cloth.springs) {
        for (const int first : {i, i - run.offset}) {  // the springs that it begins and ends
          if (first < run.first || first >= run.first + run.count) continue;
          const int other = first == i ? i + run.offset : first;
          impulses.row(i) +=
              h * pull(run, row(state.positions, i), row(state.positions, other)).transpose();
        }
      }
    }
  }
}

std::vector<int> Grips::torn() const {
  std::vector<int> points;
  for (const auto& [frame, grip] : all_) {
    if (!grip.tear_force || grip.wrench.force.norm() <= *grip.tear_force) continue;
    for (const Grip::Held& held : grip.held) points.push_back(held.point);
  }
  return points;
}

}  // namespace clothsim
