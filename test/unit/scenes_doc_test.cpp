// docs/scenes.md against the reader: same keys, defaults, units and ranges.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "clothsim/dynamics/integrator.h"
#include "clothsim/model/errors.h"
#include "clothsim/simulation/scene_yaml.h"

namespace clothsim {
namespace {

struct Row {
  std::string key, type, unit, initial, range, meaning;
};

/// The cells of a table line, without blanks at their ends and without backticks.
std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> parts;
  std::istringstream stream(line);
  for (std::string part; std::getline(stream, part, '|');) {
    part.erase(std::remove(part.begin(), part.end(), '`'), part.end());
    part.erase(0, part.find_first_not_of(' '));
    part.erase(part.find_last_not_of(' ') + 1);
    parts.push_back(part);
  }
  return parts;
}

/// The rows of the key tables, by the heading above them.
std::map<std::string, std::vector<Row>> read_tables() {
  std::map<std::string, std::vector<Row>> tables;
  std::ifstream file(CLOTHSIM_SCENES_DOC);
  std::string heading;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("##", 0) == 0) heading = line.substr(line.find(' ') + 1);
    if (line.rfind("| `", 0) != 0) continue;
    const std::vector<std::string> cell = cells(line);
    if (cell.size() == 7)
      tables[heading].push_back({cell[1], cell[2], cell[3], cell[4], cell[5], cell[6]});
  }
  return tables;
}

std::string refusal(const std::string& scene) {
  try {
    read_scene(YAML::Load(scene));
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "";
}

/// A map of a scene: the headings that list its keys, and a scene around its text.
struct Map {
  std::vector<std::string> headings;
  std::string before, after;
};

const std::vector<Map> maps = {
    {{"cloth"}, "cloth: {", "}"},
    {{"cloth.pinned"}, "cloth: {pinned: [{", "}]}"},
    {{"cloth.springs"}, "cloth: {springs: {", "}}"},
    {{"colliders", "colliders: sphere"}, "{cloth: {}, colliders: [{shape: sphere, ", "}]}"},
    {{"colliders", "colliders: plane"}, "{cloth: {}, colliders: [{shape: plane, ", "}]}"},
    {{"simulation"}, "{cloth: {}, simulation: {", "}}"},
};

/// Calls `visit(row, map)` for each row of each map.
template <class Visit>
void for_each_row(Visit visit) {
  const auto tables = read_tables();
  for (const Map& map : maps) {
    for (const std::string& heading : map.headings) {
      ASSERT_EQ(tables.count(heading), 1u) << heading;
      for (const Row& row : tables.at(heading)) visit(row, map);
    }
  }
}

TEST(ScenesDoc, HasTheKeysOfTheReader) {
  const auto tables = read_tables();
  std::set<std::string> headings;
  for (const Map& map : maps) {
    std::set<std::string> documented;
    for (const std::string& heading : map.headings) {
      headings.insert(heading);
      ASSERT_EQ(tables.count(heading), 1u) << heading;
      for (const Row& row : tables.at(heading)) documented.insert(row.key);
    }

    // The refusal of an unknown key lists the known ones.
    const std::string message = refusal(map.before + "no_such_key: 1" + map.after);
    const std::string marker = "expected one of ";
    ASSERT_NE(message.find(marker), std::string::npos) << message;
    std::istringstream list(message.substr(message.find(marker) + marker.size()));
    std::set<std::string> known;
    for (std::string key; std::getline(list, key, ',');) known.insert(key.substr(key[0] == ' '));
    EXPECT_EQ(documented, known) << map.headings.back();
  }
  EXPECT_EQ(headings.size(), tables.size()) << "a table that this test does not know";
}

TEST(ScenesDoc, HasTheDefaults) {
  int checked = 0;
  for_each_row([&](const Row& row, const Map& map) {
    const bool in_words = row.initial == "all on" || row.initial == "none" ||
                          row.initial == "must be given" || row.initial == "the shape's name";
    if (in_words || row.initial.empty() || map.headings.back() == "cloth.pinned") return;
    ++checked;

    // Equal to a scene without the key, but for the key.
    const YAML::Node given = YAML::Load(map.before + row.key + ": " + row.initial + map.after);
    const YAML::Node left_out = YAML::Load(map.before + map.after);
    const Scene a = read_scene(given);
    const Scene b = read_scene(left_out);
    EXPECT_EQ(a.cloth.width, b.cloth.width);
    EXPECT_EQ(a.cloth.height, b.cloth.height);
    EXPECT_EQ(a.cloth.columns, b.cloth.columns);
    EXPECT_EQ(a.cloth.rows, b.cloth.rows);
    EXPECT_EQ(a.cloth.orientation, b.cloth.orientation);
    EXPECT_EQ(a.cloth.origin, b.cloth.origin);
    EXPECT_EQ(a.cloth.pinned.size(), b.cloth.pinned.size());
    EXPECT_EQ(a.cloth.thickness, b.cloth.thickness);
    EXPECT_EQ(a.cloth.self_collision, b.cloth.self_collision);
    EXPECT_EQ(a.cloth.friction, b.cloth.friction);
    EXPECT_EQ(a.cloth.material.ks, b.cloth.material.ks);
    EXPECT_EQ(a.cloth.material.density, b.cloth.material.density);
    EXPECT_EQ(a.cloth.material.damping, b.cloth.material.damping);
    EXPECT_EQ(a.cloth.material.strain_limit, b.cloth.material.strain_limit);
    EXPECT_EQ(a.cloth.material.springs, b.cloth.material.springs);
    EXPECT_EQ(a.simulation.gravity, b.simulation.gravity);
    EXPECT_EQ(a.simulation.frames_per_second, b.simulation.frames_per_second);
    EXPECT_EQ(a.simulation.substeps, b.simulation.substeps);
    EXPECT_EQ(a.simulation.strain_tolerance, b.simulation.strain_tolerance);
    EXPECT_EQ(a.simulation.method, b.simulation.method);
    EXPECT_EQ(a.simulation.seed, b.simulation.seed);
    ASSERT_EQ(a.colliders.size(), b.colliders.size());
    for (size_t i = 0; i < a.colliders.size(); ++i) {
      const ColliderSpec& c = a.colliders[i];
      const ColliderSpec& d = b.colliders[i];
      EXPECT_EQ(c.friction, d.friction);
      EXPECT_EQ(c.pose.position, d.pose.position);
      EXPECT_EQ(c.pose.orientation.coeffs(), d.pose.orientation.coeffs());
      ASSERT_EQ(c.shape.index(), d.shape.index());
      if (const auto* sphere = std::get_if<Sphere>(&c.shape)) {
        EXPECT_EQ(sphere->radius, std::get<Sphere>(d.shape).radius);
      } else {
        EXPECT_EQ(std::get<Plane>(c.shape).two_sided, std::get<Plane>(d.shape).two_sided);
      }
    }
    EXPECT_FALSE(testing::Test::HasFailure()) << map.headings.back() << ": " << row.key;
  });
  EXPECT_GT(checked, 20);
}

TEST(ScenesDoc, HasTheRangesAndUnits) {
  int checked = 0;
  for_each_row([&](const Row& row, const Map& map) {
    const size_t to = row.range.find(" to ");
    if (to == std::string::npos) return;
    ++checked;
    const std::string min = row.range.substr(0, to), max = row.range.substr(to + 4);
    const bool is_vector = row.type == "[x, y, z]";
    const auto scene = [&](const std::string& value) {
      const std::string text = is_vector ? "[0, " + value + ", 0]" : value;
      return map.before + row.key + ": " + text + map.after;
    };
    EXPECT_EQ(refusal(scene(min)), "");
    EXPECT_EQ(refusal(scene(max)), "");

    // One below, and ten times above, by text, since a double does not hold the largest seed.
    const std::string below = std::to_string(std::stod(min) - 1);
    const std::string low =
        row.type == "number" || is_vector ? below : below.substr(0, below.find('.'));
    const std::string high = max.find('e') == std::string::npos ? max + "0" : max + "1";
    for (const std::string& value : {low, high}) {
      const std::string message = refusal(scene(value));
      EXPECT_NE(message.find(row.key), std::string::npos) << row.key << ' ' << value;
      if (!row.unit.empty()) {
        EXPECT_NE(message.find('[' + row.unit + ']'), std::string::npos) << message;
      }
    }
  });
  EXPECT_GT(checked, 15);
}

TEST(ScenesDoc, NamesEveryMethod) {
  const auto tables = read_tables();
  for (const Row& row : tables.at("simulation")) {
    if (row.key != "method") continue;
    for (const std::string& method : method_names()) {
      EXPECT_NE(row.meaning.find(method), std::string::npos) << method;
    }
  }
}

}  // namespace
}  // namespace clothsim
