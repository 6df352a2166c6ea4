#include "clothsim/scene/points_yaml.h"

#include <algorithm>
#include <unordered_set>

#include "clothsim/model/make_cloth.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {
namespace {

const char* const ways_to_name = "[column, row], or a map with near, within and of, or uv";
const char* const ways_to_name_on_mesh =
    "the number of a point, or a map with near, within and of, uv, or corner or side of a pattern";

/// Points on the rim of a distance are within it [m].
constexpr double rim_tolerance = 1e-6;

/// The first of the nearest rows.
template <class Differences>
int nearest_row(const Differences& differences) {
  const Eigen::VectorXd distances = differences.rowwise().squaredNorm();
  const double* first = distances.data();
  return static_cast<int>(std::min_element(first, first + distances.size()) - first);
}

/// The value of a name of a pattern. Throws InvalidValue.
template <typename Value>
Value named(const char* key, const std::string& name, const std::map<std::string, Value>& names) {
  const auto found = names.find(name);
  if (found != names.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [each, value] : names) known.push_back(each);
  throw InvalidValue({key}, '"' + name + '"',
                     known.empty() ? "none, as the cloth has no pattern" : "one of " + join(known));
}

}  // namespace

std::vector<Field> fields(PointPlace& place) {
  const auto read_uv = [&](const YAML::Node& list) {
    if (!list.IsSequence() || list.size() != 2) throw InvalidValue({}, describe(list), "[u, v]");
    Eigen::Index k = 0;
    place.uv.emplace();
    read_list(list, [&](const YAML::Node& item) {
      const double value = read_number(item);
      if (!(value >= 0 && value <= 1)) throw InvalidValue({}, to_text(value), "0 to 1");
      (*place.uv)[k++] = value;
    });
  };
  return {{"near", [&](const YAML::Node& node) { place.near = read_vector(node); }},
          {"within", [&](const YAML::Node& node) { place.within = read_number(node); }},
          {"of", [&](const YAML::Node& node) { place.of = read_vector(node); }},
          {"uv", read_uv},
          {"corner", [&](const YAML::Node& node) { into(place.corner.emplace())(node); }},
          {"side", [&](const YAML::Node& node) { into(place.side.emplace())(node); }}};
}

PointReader::PointReader(const ClothSpec& spec, const ClothPart* part, const Cloth* made)
    : spec_(spec), first_(part ? part->first_point : 0), made_(made) {
  named_.columns = part ? part->columns : spec.columns;
  named_.rows = part ? part->rows : spec.rows;
  if (!part || !part->is_grid) named_.mesh = spec.mesh;
  named_.pattern = part ? part->pattern : spec.pattern;
}

std::vector<std::array<int, 2>> PointReader::read(const YAML::Node& node) {
  if (node.IsMap()) {
    PointPlace place;
    read_map(node, fields(place));
    return find(place);
  }
  if (named_.mesh) {
    const int point = read_int(node, ways_to_name_on_mesh);
    check_grid_point(named_, point, 0);
    return {{{point, 0}}};
  }
  if (!node.IsSequence() || node.size() != 2) throw InvalidValue({}, describe(node), ways_to_name);
  std::array<int, 2> point{};
  std::size_t k = 0;
  read_list(node, [&](const YAML::Node& item) { point[k++] = read_int(item); });
  check_grid_point(named_, point[0], point[1]);
  return {point};
}

std::vector<int> PointReader::read_indices(const YAML::Node& node) {
  if (node.IsScalar()) {
    const int number = read_int(node), count = named_.columns * named_.rows;
    if (number < 0 || number >= count) {
      throw InvalidValue({}, std::to_string(number),
                         "a point of the cloth, from 0 to " + std::to_string(count - 1));
    }
    return {first_ + number};
  }
  std::vector<int> indices;
  for (const auto& [column, row] : read(node)) {
    indices.push_back(first_ + row * named_.columns + column);
  }
  return indices;
}

const Cloth& PointReader::cloth() {
  if (made_ != nullptr) return *made_;
  if (!cloth_) {
    ClothSpec free = spec_;  // its points may be invalid yet
    free.pinned.clear();
    cloth_ = make_cloth(free);
  }
  return *cloth_;
}

std::vector<std::array<int, 2>> PointReader::find(const PointPlace& place) {
  const int given = place.near.has_value() + place.of.has_value() + place.uv.has_value() +
                    place.corner.has_value() + place.side.has_value();
  if (given != 1 || place.within.has_value() != place.of.has_value()) {
    throw InvalidValue({}, place.empty() ? "no place" : "a part of a place, or two",
                       named_.mesh ? ways_to_name_on_mesh : ways_to_name);
  }
  std::vector<int> found;
  const auto own = [&](const auto& of_points) {
    return of_points.middleRows(first_, named_.columns * named_.rows);
  };
  if (place.near) {
    found = {nearest_row(own(cloth().rest_positions).rowwise() - place.near->transpose())};
  }
  if (place.uv) found = {nearest_row(own(cloth().uv).rowwise() - place.uv->transpose())};
  if (place.of) found = within(*place.within, *place.of);
  const PatternPoints none, &names = named_.pattern ? *named_.pattern : none;
  if (place.corner) found = {named("corner", *place.corner, names.corners)};
  if (place.side) found = named("side", *place.side, names.sides);
  std::vector<std::array<int, 2>> points;
  for (const int i : found) points.push_back({i % named_.columns, i / named_.columns});
  return points;
}

std::vector<int> PointReader::within(double radius, const Vector3& center) {
  std::vector<int> found;
  const Points& points = cloth().rest_positions;
  for (int i = 0; i < named_.columns * named_.rows; ++i) {
    if ((points.row(first_ + i) - center.transpose()).norm() <= radius + rim_tolerance) {
      found.push_back(i);
    }
  }
  if (found.empty()) {
    throw InvalidValue({"within"}, to_text(radius), "a distance with points of the cloth");
  }
  return found;
}

PointReaders::PointReaders(const ClothSpec& cloth, const Cloth* made) : all_(cloth, nullptr, made) {
  for (const ClothPart& part : cloth.parts) {
    named_.emplace(part.name, PointReader(cloth, &part, made));
  }
}

PointReader& PointReaders::of(const std::string& name) {
  const auto found = named_.find(name);
  if (found != named_.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, reader] : named_) names.push_back(known);
  throw InvalidValue({"cloth"}, '"' + name + '"',
                     names.empty() ? "none, as the scene has one cloth" : "one of " + join(names));
}

std::vector<int> read_points(const YAML::Node& list, PointReader& reader) {
  std::vector<int> points;
  std::unordered_set<int> known;
  read_list(list, [&](const YAML::Node& item) {
    const bool is_side = item.IsMap() && item["side"].IsDefined();  // sides share points
    for (const int point : reader.read_indices(item)) {
      const bool is_new = known.insert(point).second;
      if (is_new) points.push_back(point);
      if (!is_new && !is_side) {
        throw InvalidValue({}, std::to_string(point) + " again", "each point once");
      }
    }
  });
  return points;
}

}  // namespace clothsim
