#include "clothsim/model/join_cloths.h"

#include <algorithm>
#include <memory>

#include "clothsim/model/grid.h"

namespace clothsim {
namespace {

std::string text(bool value) { return value ? "true" : "false"; }
std::string text(SelfCollision value) {
  return self_collision_names[static_cast<std::size_t>(value)];
}

/// Calls visit(key, value of one, value of other) for the values that cloths share.
template <typename Visit>
void for_each_shared(const ClothSpec& one, const ClothSpec& other, Visit&& visit) {
  visit("self_collision", one.self_collision, other.self_collision);
  visit("untangle", one.untangle, other.untangle);
}

void check(const NamedCloth& cloth, const NamedCloth& first) {
  if (cloth.name.empty()) throw InvalidValue({"name"}, "an empty name", "a name");
  const ClothSpec& spec = cloth.spec;
  validate(spec);
  if (!spec.material.fabric) {
    throw InvalidValue({"fabric"}, "none", "a fabric, which one of several cloths needs");
  }
  if (!spec.mesh && (spec.columns < 2 || spec.rows < 2)) {
    throw InvalidValue({spec.columns < 2 ? "columns" : "rows"},
                       std::to_string(std::min(spec.columns, spec.rows)),
                       "at least 2 in one of several cloths");
  }
  for_each_shared(spec, first.spec, [&](const char* key, const auto& own, const auto& shared) {
    if (own == shared) return;
    throw InvalidValue(
        {key}, text(own),
        text(shared) + ", that of " + first.name + ", as all cloths of a scene share this value");
  });
}

/// A grid as triangles, its threads along rows and columns.
ClothMesh mesh_of_grid(ClothSpec spec) {
  spec.material.springs = {};
  const Cloth grid = make_grid(spec);
  ClothMesh mesh{grid.rest_positions, grid.triangles, {}, grid.uv, {}};
  const auto flat = [&](int i) {
    return ClothMesh::Flat(grid.uv(i, 0) * spec.width, grid.uv(i, 1) * spec.height);
  };
  for (const auto& [a, b, c] : grid.triangles) mesh.flat.push_back({flat(a), flat(b), flat(c)});
  return mesh;
}

void append(const ClothMesh& more, ClothMesh& mesh) {
  const auto first = static_cast<int>(mesh.positions.rows());
  const auto count = more.positions.rows();
  mesh.positions.conservativeResize(first + count, 3);
  mesh.positions.bottomRows(count) = more.positions;
  mesh.uv.conservativeResize(first + count, 2);
  mesh.uv.bottomRows(count) = more.uv;
  mesh.flat.insert(mesh.flat.end(), more.flat.begin(), more.flat.end());
  if (!mesh.curved.empty() || !more.curved.empty()) {
    mesh.curved.resize(mesh.triangles.size());
    mesh.curved.insert(mesh.curved.end(), more.curved.begin(), more.curved.end());
    mesh.curved.resize(mesh.triangles.size() + more.triangles.size());
  }
  for (const auto& [a, b, c] : more.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

/// Pins and points on bodies, by their number in all cloths.
void append_held(const ClothSpec& cloth, int first, ClothSpec& joined) {
  for (Pin pin : cloth.pinned) {
    pin.column += first + pin.row * cloth.columns;
    pin.row = 0;
    if (!pin.strength) pin.strength = cloth.pin_strength;
    joined.pinned.push_back(pin);
  }
  for (BodyPoints attached : cloth.attached) {
    for (auto& [column, row] : attached.points) {
      column += first + row * cloth.columns;
      row = 0;
    }
    joined.attached.push_back(attached);
  }
}

}  // namespace

ClothSpec join_cloths(const std::vector<NamedCloth>& cloths) {
  if (cloths.empty()) throw InvalidValue({}, "an empty list", "one or more cloths");
  ClothSpec joined = cloths.front().spec;
  joined.pinned.clear();
  joined.attached.clear();
  joined.pin_strength.reset();
  joined.pattern.reset();
  ClothMesh mesh;
  for (std::size_t i = 0; i < cloths.size(); ++i) {
    inside(std::to_string(i), [&] {
      const auto& [name, spec] = cloths[i];
      check(cloths[i], cloths.front());
      for (const ClothPart& other : joined.parts) {
        if (other.name == name) {
          throw InvalidValue({"name"}, '"' + name + "\" again", "a name of its own");
        }
      }
      const auto first = static_cast<int>(mesh.positions.rows());
      const auto first_triangle = static_cast<int>(mesh.triangles.size());
      append(spec.mesh ? *spec.mesh : mesh_of_grid(spec), mesh);
      joined.parts.push_back({name, first, spec.columns, spec.rows, first_triangle,
                              static_cast<int>(mesh.triangles.size()) - first_triangle,
                              spec.material, spec.friction, spec.thickness, spec.mesh == nullptr,
                              !spec.mesh && spec.orientation == Orientation::vertical, spec.width,
                              spec.height, joined.attached.size(), spec.pattern});
      append_held(spec, first, joined);
    });
  }
  joined.columns = static_cast<int>(mesh.positions.rows());
  joined.rows = 1;
  joined.mesh = std::make_shared<const ClothMesh>(std::move(mesh));
  return joined;
}

}  // namespace clothsim
