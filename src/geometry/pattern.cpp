#include "clothsim/geometry/pattern.h"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <map>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Largest difference in length of the sides of a seam, of the longer one: more is a mistake.
constexpr double most_ease = 0.5;

/// Least number of segments of a curved side.
constexpr int least_of_curve = 4;

/// Things that are joined to groups.
using PointGroups = boost::disjoint_sets_with_storage<>;

class Sewer {
 public:
  explicit Sewer(const Pattern& pattern) : pattern_(pattern) {
    for (const Panel& panel : pattern.panels) {
      first_sides_.push_back(first_sides_.back() + panel.sides.size());
    }
  }

  SewnPattern sew() {
    count_points();
    fill();
    join();
    return result();
  }

 private:
  /// The number of a side among those of all panels.
  std::size_t number(const SideName& name) const { return first_sides_[name.panel] + name.side; }

  const PanelSide& side(const SideName& name) const {
    return pattern_.panels[name.panel].sides[name.side];
  }

  /// Segments of each side: as many on all sides that are sewn to each other.
  void count_points() {
    PointGroups groups(first_sides_.back());
    for (std::size_t s = 0; s < pattern_.seams.size(); ++s) {
      const auto& [a, b] = pattern_.seams[s];
      check_lengths(s, length_of(side(a)), length_of(side(b)));
      groups.union_set(number(a), number(b));
    }
    // With one segment an opening between two seams would be closed by them.
    std::vector<int> of_group(first_sides_.back(), 2);
    for (const auto& [a, b] : pattern_.seams) of_group[groups.find_set(number(a))] = 1;
    const auto for_each_side = [&](const auto& visit) {
      for (std::size_t p = 0; p < pattern_.panels.size(); ++p) {
        for (std::size_t k = 0; k < pattern_.panels[p].sides.size(); ++k) {
          const std::size_t i = number({p, k});
          visit(i, groups.find_set(i), pattern_.panels[p].sides[k]);
        }
      }
    };
    for_each_side([&](std::size_t, std::size_t group, const PanelSide& line) {
      const bool is_curved = line.size() > 2;
      const auto count = std::max(static_cast<int>(std::lround(length_of(line) / pattern_.cell)),
                                  is_curved ? least_of_curve : 1);
      of_group[group] = std::max(of_group[group], count);
    });
    segments_.resize(first_sides_.back());
    for_each_side([&](std::size_t i, std::size_t group, const PanelSide&) {
      segments_[i] = of_group[group];
    });
  }

  static void check_lengths(std::size_t seam, double one, double other) {
    const double longer = std::max(one, other);
    if (std::abs(one - other) <= most_ease * longer) return;
    throw InvalidValue({"seams", std::to_string(seam)},
                       "sides of " + to_text(one) + " and " + to_text(other) + " m",
                       "sides whose lengths differ by half of the longer one at most");
  }

  void fill() {
    for (std::size_t p = 0; p < pattern_.panels.size(); ++p) {
      const Panel& panel = pattern_.panels[p];
      std::vector<PlanePoint> outline;
      std::vector<int> first_points;
      for (std::size_t k = 0; k < panel.sides.size(); ++k) {
        first_points.push_back(static_cast<int>(outline.size()));
        std::vector<PlanePoint> points = points_along(panel.sides[k], segments_[number({p, k})]);
        outline.insert(outline.end(), points.begin(), points.end() - 1);
      }
      outline_sizes_.push_back(static_cast<int>(outline.size()));
      first_of_side_.push_back(first_points);
      inside("panels", [&] {
        inside(std::to_string(p), [&] {
          meshes_.push_back(fill_panel(outline, pattern_.cell, sewn_points(p, outline.size())));
        });
      });
      first_points_.push_back(static_cast<int>(places_.size()));
      for (const PlanePoint& x : meshes_.back().points) {
        places_.push_back(panel.origin + panel.turn * Vector3(x.x(), x.y(), 0));
      }
    }
  }

  /// Which points of a panel's outline are on a seam.
  std::vector<bool> sewn_points(std::size_t panel, std::size_t count) const {
    std::vector<bool> sewn(count, false);
    for (const auto& seam : pattern_.seams) {
      for (const SideName& name : seam) {
        if (name.panel != panel) continue;
        const int first = first_of_side_[panel][name.side];
        for (int k = 0; k <= segments_[number(name)]; ++k) {
          sewn[static_cast<std::size_t>(first + k) % count] = true;
        }
      }
    }
    return sewn;
  }

  /// The number of point k of a side among all points.
  std::size_t point(const SideName& name, int k) const {
    const int first = first_of_side_[name.panel][name.side];
    return static_cast<std::size_t>(first_points_[name.panel] +
                                    (first + k) % outline_sizes_[name.panel]);
  }

  /// Moves the points of seams to the middle of their places.
  void join() {
    PointGroups groups(places_.size());
    for (const auto& [a, b] : pattern_.seams) {
      const int last = segments_[number(a)];
      const auto gap = [&](int of_a, int of_b) {
        return (places_[point(a, of_a)] - places_[point(b, of_b)]).norm();
      };
      const bool is_reversed = gap(0, last) + gap(last, 0) < gap(0, 0) + gap(last, last);
      for (int k = 0; k <= last; ++k)
        groups.union_set(point(a, k), point(b, is_reversed ? last - k : k));
    }
    std::vector<Vector3> sums(places_.size(), Vector3::Zero());
    std::vector<int> counts(places_.size(), 0);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      sums[groups.find_set(i)] += places_[i];
      ++counts[groups.find_set(i)];
    }
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (counts[groups.find_set(i)] > 1)
        places_[i] = sums[groups.find_set(i)] / counts[groups.find_set(i)];
    }
    check_touching(groups);
  }

  /// Throws InvalidValue for points at one place, which become one point of the cloth, without a
  /// seam.
  void check_touching(PointGroups& groups) const {
    std::map<std::array<double, 3>, std::size_t> group_at;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Vector3& x = places_[i];
      const std::size_t group = groups.find_set(i);
      const auto [at, is_new] = group_at.emplace(std::array<double, 3>{x.x(), x.y(), x.z()}, group);
      if (is_new || at->second == group) continue;
      throw InvalidValue({"panels"},
                         "panels that touch at " + place_text(x) + " without a seam there",
                         "panels that are sewn where they touch, or start apart");
    }
  }

  SewnPattern result() const {
    SewnPattern sewn;
    sewn.mesh.vertices = places_;
    sewn.mesh.has_texture = false;
    for (std::size_t p = 0; p < pattern_.panels.size(); ++p) {
      const Panel& panel = pattern_.panels[p];
      const PlanePoint along = panel.warp.normalized(), across(-along.y(), along.x());
      for (const PlanePoint& x : meshes_[p].points) {
        sewn.mesh.uv.emplace_back(along.dot(x), across.dot(x));
      }
      for (const auto& [a, b, c] : meshes_[p].triangles) {
        const int first = first_points_[p];
        sewn.mesh.triangles.push_back({first + a, first + b, first + c});
      }
      sewn.sides.emplace_back();
      for (std::size_t k = 0; k < panel.sides.size(); ++k) {
        std::vector<Vector3>& places = sewn.sides.back().emplace_back();
        for (int i = 0; i <= segments_[number({p, k})]; ++i) {
          places.push_back(places_[point({p, k}, i)]);
        }
      }
    }
    return sewn;
  }

  const Pattern& pattern_;
  std::vector<std::size_t> first_sides_{0};      // by panel, among all sides
  std::vector<int> segments_;                    // by side
  std::vector<PanelMesh> meshes_;                // by panel
  std::vector<int> outline_sizes_;               // by panel: points
  std::vector<int> first_points_;                // by panel, among all points
  std::vector<std::vector<int>> first_of_side_;  // by panel and side, among the panel's points
  std::vector<Vector3> places_;                  // of all points [m]
};

}  // namespace

SewnPattern sew(const Pattern& pattern) { return Sewer(pattern).sew(); }

}  // namespace clothsim
