#include "clothsim/scene/pattern_yaml.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "clothsim/geometry/pattern.h"
#include "clothsim/model/checks.h"
#include "clothsim/scene/colliders_yaml.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {
namespace {

constexpr Range cell_range{1e-4, 10, "m"};

/// Largest coordinate in a panel [m].
constexpr double farthest = 100;

/// Most cells around a panel: with more, a panel takes minutes to fill.
constexpr double most_cells = 800;

PlanePoint read_place(const YAML::Node& node) {
  if (!node.IsSequence() || node.size() != 2) throw InvalidValue({}, describe(node), "[x, y]");
  PlanePoint place;
  Eigen::Index k = 0;
  read_list(node, [&](const YAML::Node& item) {
    const double value = read_number(item);
    if (std::abs(value) > farthest) {
      throw InvalidValue({}, to_text(value),
                         to_text(-farthest) + " to " + to_text(farthest) + " [m]");
    }
    place[k++] = value;
  });
  return place;
}

/// The part of an outline between two corners; a straight line where both are empty.
struct GivenSide {
  std::optional<PlanePoint> arc;
  std::vector<PlanePoint> curve;

  PanelSide side(const PlanePoint& from, const PlanePoint& to) const {
    if (arc) return arc_side(from, *arc, to);
    return curve.empty() ? straight_side(from, to) : curved_side(from, curve, to);
  }
};

GivenSide read_side(const YAML::Node& node) {
  GivenSide side;
  const auto read_curve = [&](const YAML::Node& list) {
    read_list(list, [&](const YAML::Node& item) { side.curve.push_back(read_place(item)); });
  };
  read_map(node, {{"arc", [&](const YAML::Node& value) { side.arc = read_place(value); }},
                  {"curve", read_curve}});
  if (side.arc.has_value() == !side.curve.empty()) {
    throw InvalidValue({}, describe(node), "arc: [x, y], or curve: a list of [x, y]");
  }
  return side;
}

std::vector<PanelSide> read_outline(const YAML::Node& node) {
  std::vector<PlanePoint> corners;
  std::vector<std::pair<GivenSide, std::size_t>> given_sides;  // after each corner, and its item
  std::size_t index = 0;
  read_list(node, [&](const YAML::Node& item) {
    if (!item.IsMap()) {
      corners.push_back(read_place(item));
      given_sides.emplace_back();
    } else if (corners.empty() || given_sides.back().second != 0) {
      throw InvalidValue({}, describe(item), "a corner [x, y] before each arc or curve");
    } else {
      given_sides.back() = {read_side(item), index};
    }
    ++index;
  });
  if (corners.size() < 2) {
    throw InvalidValue({}, std::to_string(corners.size()) + " corners", "two or more");
  }
  std::vector<PanelSide> sides;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    inside(std::to_string(given_sides[k].second), [&] {
      sides.push_back(given_sides[k].first.side(corners[k], corners[(k + 1) % corners.size()]));
    });
    if (length_of(sides.back()) > 0) continue;
    throw InvalidValue({}, "corner " + std::to_string(k) + " again", "a corner at another place");
  }
  return sides;
}

Panel read_panel(const YAML::Node& node) {
  Panel panel;
  const auto read_warp = [&](const YAML::Node& value) {
    panel.warp = read_place(value);
    if (panel.warp.norm() < written_rounding) {
      throw InvalidValue({}, describe(value), "a direction");
    }
  };
  Pose pose;
  read_map(node, {{"name", into(panel.name)},
                  {"outline", [&](const YAML::Node& list) { panel.sides = read_outline(list); }},
                  {"warp", read_warp},
                  {"pose", [&](const YAML::Node& value) { read_pose(value, pose); }}});
  if (panel.name.empty()) throw InvalidValue({"name"}, "nothing", "a name");
  if (panel.sides.empty()) throw InvalidValue({"outline"}, "nothing", "a list of corners");
  inside("pose", [&] { check_range("xyz", pose.position, position_range); });
  panel.origin = pose.position;
  panel.turn = pose.orientation;
  return panel;
}

std::string name_of(const Panel& panel, std::size_t side) {
  return panel.name + '.' + std::to_string(side);
}

/// A side by PANEL.NUMBER.
SideName read_side(const YAML::Node& node, const std::vector<Panel>& panels) {
  std::string name;
  into(name)(node);
  std::vector<std::string> known;
  for (std::size_t p = 0; p < panels.size(); ++p) {
    for (std::size_t k = 0; k < panels[p].sides.size(); ++k) {
      known.push_back(name_of(panels[p], k));
      if (known.back() == name) return {p, k};
    }
  }
  throw InvalidValue({}, '"' + name + '"', "one of " + join(known));
}

std::array<SideName, 2> read_seam(const YAML::Node& node, const std::vector<Panel>& panels) {
  std::array<SideName, 2> seam{};
  if (!node.IsSequence() || node.size() != 2) {
    throw InvalidValue({}, describe(node), "two sides, [PANEL.NUMBER, PANEL.NUMBER]");
  }
  std::size_t k = 0;
  read_list(node, [&](const YAML::Node& item) { seam[k++] = read_side(item, panels); });
  if (seam[0].panel == seam[1].panel && seam[0].side == seam[1].side) {
    throw InvalidValue({}, describe(node), "two different sides");
  }
  return seam;
}

Pattern read(const YAML::Node& node) {
  Pattern pattern;
  std::optional<YAML::Node> seams;  // read when the panels are known
  read_map(node, {{"cell", into(pattern.cell)},
                  {"panels",
                   [&](const YAML::Node& list) {
                     read_list(list, [&](const YAML::Node& item) {
                       pattern.panels.push_back(read_panel(item));
                     });
                   }},
                  {"seams", [&](const YAML::Node& list) { seams = list; }}});
  if (pattern.panels.empty()) throw InvalidValue({"panels"}, "none", "one or more");
  check_range("cell", pattern.cell, cell_range);
  for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
    for (std::size_t other = 0; other < p; ++other) {
      if (pattern.panels[other].name != pattern.panels[p].name) continue;
      throw InvalidValue({"panels", std::to_string(p), "name"},
                         '"' + pattern.panels[p].name + "\" again", "a name of its own");
    }
    double around = 0;
    for (const PanelSide& side : pattern.panels[p].sides) around += length_of(side);
    if (around <= most_cells * pattern.cell) continue;
    throw InvalidValue({"cell"}, to_text(pattern.cell),
                       to_text(around / most_cells) + " or more, as panel " +
                           pattern.panels[p].name + " has an outline of " + to_text(around) + " m");
  }
  const auto read_seams = [&] {
    read_list(*seams, [&](const YAML::Node& item) {
      pattern.seams.push_back(read_seam(item, pattern.panels));
    });
  };
  if (seams) inside("seams", read_seams);
  return pattern;
}

/// The points of the mesh at the places of corners and sides, which they have exactly.
PatternPoints find_points(const Pattern& pattern, const SewnPattern& sewn, const ClothMesh& mesh) {
  std::map<std::array<double, 3>, int> points;
  for (int i = 0; i < static_cast<int>(mesh.positions.rows()); ++i) {
    points.emplace(
        std::array<double, 3>{mesh.positions(i, 0), mesh.positions(i, 1), mesh.positions(i, 2)}, i);
  }
  PatternPoints names;
  for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
    for (std::size_t k = 0; k < sewn.sides[p].size(); ++k) {
      const std::string name = name_of(pattern.panels[p], k);
      std::vector<int>& side = names.sides[name];
      for (const Vector3& x : sewn.sides[p][k]) {
        const int point = points.at({x.x(), x.y(), x.z()});
        const bool is_known = std::find(side.begin(), side.end(), point) != side.end();
        if (!is_known) side.push_back(point);  // a side sewn to itself ends where it begins
      }
      names.corners[name] = side.front();
    }
  }
  return names;
}

}  // namespace

void read_pattern(const YAML::Node& node, ClothSpec& cloth) {
  const Pattern pattern = read(node);
  const SewnPattern sewn = sew(pattern);
  ClothMesh mesh = make_cloth_mesh(sewn.mesh, Vector3::UnitX(), RestLengths::uv);
  cloth.pattern = std::make_shared<const PatternPoints>(find_points(pattern, sewn, mesh));
  cloth.columns = static_cast<int>(mesh.positions.rows());
  cloth.rows = 1;
  cloth.mesh = std::make_shared<const ClothMesh>(std::move(mesh));
}

}  // namespace clothsim
