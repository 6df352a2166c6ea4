#pragma once

#include <yaml-cpp/yaml.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/cloth_spec.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {

/// Points of a cloth by their place at the start, one of `near`, `within` with `of`, and `uv`; or
/// by the names of a pattern, PANEL.NUMBER.
struct PointPlace {
  std::optional<Vector3> near;        // the nearest point [m]
  std::optional<double> within;       // all points within this distance [m] ...
  std::optional<Vector3> of;          // ... of this place [m]
  std::optional<Eigen::Vector2d> uv;  // the point with the nearest texture coordinates, 0 to 1
  std::optional<std::string> corner;  // of a panel
  std::optional<std::string> side;    // all points of a side of a panel

  bool empty() const { return !near && !within && !of && !uv && !corner && !side; }
};

/// Its keys, for read_map().
std::vector<Field> fields(PointPlace&);

/// Reads which points of a cloth a scene names, as [column, row] or by their place. Points that are
/// equally near: the first. Throws InvalidValue.
class PointReader {
 public:
  /// For the cloth of `spec`, which is valid apart from its pins, or for one of its parts, by its
  /// own [column, row]. `made`: that cloth, if it exists; it must outlive this.
  explicit PointReader(const ClothSpec& spec, const ClothPart* part = nullptr,
                       const Cloth* made = nullptr);

  /// [column, row] in the grid, or a map with a place. Not for parts.
  std::vector<std::array<int, 2>> read(const YAML::Node&);
  std::vector<std::array<int, 2>> find(const PointPlace&);

  /// The same as indices in the cloth of `spec`; also a number, of a part by its own count.
  std::vector<int> read_indices(const YAML::Node&);

 private:
  const Cloth& cloth();
  std::vector<int> within(double radius, const Vector3& center);

  const ClothSpec& spec_;
  ClothSpec named_;             // the cloth whose points are named: its mesh, columns and rows
  int first_;                   // its first point
  const Cloth* made_;           // null: none
  std::optional<Cloth> cloth_;  // else, once a place is named
};

/// Readers of the points of all cloths, and of each of several by its name.
class PointReaders {
 public:
  /// As for PointReader.
  explicit PointReaders(const ClothSpec&, const Cloth* made = nullptr);

  PointReader& all() { return all_; }
  /// That of the cloth `name`. Throws InvalidValue where there is none.
  PointReader& of(const std::string& name);

 private:
  PointReader all_;
  std::map<std::string, PointReader> named_;
};

/// Reads a list of points as indices. Throws InvalidValue, also for a point that is named twice.
std::vector<int> read_points(const YAML::Node& list, PointReader&);

}  // namespace clothsim
