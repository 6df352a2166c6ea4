// docs/scenes.md against the reader: same keys, defaults, units and ranges.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "clothsim/dynamics/integrator.h"
#include "meshes.h"
#include "scene_text.h"

namespace clothsim::scenes_doc_test {
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

/// A map of a scene: the headings that list its keys, and a scene around its text.
struct Map {
  std::vector<std::string> headings;
  std::string before, after;
};

/// A mesh for scenes to name.
std::string box_file() {
  const std::string path = ::testing::TempDir() + "clothsim_scenes_doc.obj";
  test::write_obj(path, test::box_soup({0.1, 0.2, 0.3}));
  return path;
}

/// A cloth for scenes to name.
std::string sheet_file() {
  const std::string path = ::testing::TempDir() + "clothsim_scenes_doc_sheet.obj";
  std::ofstream(path) << "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n";
  return path;
}

/// A robot for scenes to name.
std::string urdf_file() {
  const std::string path = ::testing::TempDir() + "clothsim_scenes_doc.urdf";
  std::ofstream(path)
      << "<robot name='r'><link name='l'><collision><geometry><sphere radius='0.1'/>"
         "</geometry></collision></link></robot>";
  return path;
}

const std::vector<Map> fixed_maps = {
    {{"cloth"}, "cloth: {", "}"},
    {{"cloth.mesh"}, "cloth: {fabric: felt, mesh: {file: " + sheet_file() + ", ", "}}"},
    {{"cloth.pattern"},
     "cloth: {fabric: felt, pattern: {panels: [{name: a, outline: [[0, 0], [0.01, 0], [0, "
     "0.01]]}], ",
     "}}"},
    {{"cloth.pattern.panels"},
     "cloth: {fabric: felt, pattern: {panels: [{name: a, outline: [[0, 0], [1, 0], [0, 1]], ",
     "}]}}"},
    {{"cloth.pinned", "Points by place"}, "cloth: {pinned: [{point: [0, 0], ", "}]}"},
    {{"Points by place"}, "{cloth: {}, motions: [{attach: a, points: [{", "}]}]}"},
    {{"cloth.attached"},
     "{colliders: [{shape: box, name: a, mass: 1}], "
     "cloth: {attached: [{body: a, points: [[0, 0]], ",
     "}]}}"},
    {{"cloth.springs"}, "cloth: {springs: {", "}}"},
    {{"colliders", "colliders: sphere"}, "{cloth: {}, colliders: [{shape: sphere, ", "}]}"},
    {{"colliders", "colliders: plane"}, "{cloth: {}, colliders: [{shape: plane, ", "}]}"},
    {{"colliders", "colliders: capsule"}, "{cloth: {}, colliders: [{shape: capsule, ", "}]}"},
    {{"colliders", "colliders: box"}, "{cloth: {}, colliders: [{shape: box, ", "}]}"},
    {{"colliders", "colliders: cylinder"}, "{cloth: {}, colliders: [{shape: cylinder, ", "}]}"},
    {{"colliders", "colliders: mesh"},
     "{cloth: {}, colliders: [{shape: mesh, file: " + box_file() + ", ",
     "}]}"},
    {{"colliders", "colliders: box", "colliders: body"},
     "{cloth: {}, colliders: [{shape: box, mass: 1, ",
     "}]}"},
    {{"colliders: joint"},
     "{cloth: {}, colliders: [{shape: box, mass: 1, joint: {type: slider, ",
     "}}]}"},
    {{"colliders: pose"}, "{cloth: {}, colliders: [{shape: sphere, pose: {", "}}]}"},
    {{"robots"}, "{cloth: {}, robots: [{file: " + urdf_file() + ", ", "}]}"},
    {{"simulation"}, "{cloth: {}, simulation: {", "}}"},
    {{"motions: frame"}, "{cloth: {}, motions: [{frame: a, position: [0, 0, 0], ", "}]}"},
    {{"motions: file"}, "{cloth: {}, motions: [{file: a.csv, frame: a, ", "}]}"},
    {{"motions: attach"}, "{cloth: {}, motions: [{attach: a, points: [1], ", "}]}"},
    {{"motions: detach"}, "{cloth: {}, motions: [{detach: a, ", "}]}"},
    {{"motions: enable"},
     "{cloth: {}, colliders: [{shape: sphere, name: a}], motions: [{enable: a, ",
     "}]}"},
    {{"motions: set"}, "{cloth: {}, motions: [{set: {}, ", "}]}"},
};

/// The fixed maps, and one for each method that has parameters.
std::vector<Map> all_maps() {
  std::vector<Map> all = fixed_maps;
  for (const std::string& method : method_names()) {
    bool has_parameters = false;
    std::visit(
        [&](const auto& parameters) {
          using Parameters = std::decay_t<decltype(parameters)>;
          if constexpr (!std::is_same_v<Parameters, std::monostate>) {
            Parameters::each(parameters, [&](auto&&...) { has_parameters = true; });
          }
        },
        default_parameters(method));
    if (!has_parameters) continue;
    all.push_back({{"simulation.method_parameters: " + method},
                   "{cloth: {}, simulation: {method: " + method + ", method_parameters: {",
                   "}}}"});
  }
  return all;
}

const std::vector<Map> maps = all_maps();

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

    const Scene given =
        read_scene(YAML::Load(map.before + row.key + ": " + row.initial + map.after));
    const Scene left_out = read_scene(YAML::Load(map.before + map.after));
    EXPECT_EQ(print(given), print(left_out)) << map.headings.back() << ": " << row.key;
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
      const std::string text = is_vector ? "[" + value + ", " + value + ", " + value + "]" : value;
      return map.before + row.key + ": " + text + map.after;
    };
    EXPECT_EQ(refusal(scene(min)), "accepted");
    EXPECT_EQ(refusal(scene(max)), "accepted");

    // One below, and by a digit above, as text, since a double does not hold the largest seed.
    const std::string below = std::to_string(std::stod(min) - 1);
    const std::string low =
        row.type == "number" || is_vector ? below : below.substr(0, below.find('.'));
    const std::string high = max.find('e') == std::string::npos ? max + "9" : max + "1";
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
}  // namespace clothsim::scenes_doc_test
