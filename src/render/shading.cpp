#include "clothsim/render/shading.h"

#include <cstddef>
#include <type_traits>
#include <utility>

#include "ranges.h"

namespace clothsim {
namespace {

// Far beyond the range of an image; the bounds keep the sums in the shaders finite.
constexpr Range coefficient{0, 1e3, ""};
constexpr Range exponent{1e-3, 1e5, ""};
constexpr Range scaling{-1e3, 1e3, ""};
constexpr Range height_range{-1e3, 1e3, "m"};
constexpr Range level_count{1, 256, ""};  // 8-bit images have no more

void check(const Phong& p) {
  check_range("ka", p.ka, coefficient);
  check_range("kd", p.kd, coefficient);
  check_range("ks", p.ks, coefficient);
  check_range("power", p.power, exponent);
}

void check(const Wireframe& s) {
  for (const Color& color : s.colors) check_range("colors", color, channel_range);
}
void check(const NormalColor&) {}
void check(const Diffuse& s) {
  check_range("color", s.color, channel_range);
  check_range("kd", s.kd, coefficient);
}
void check(const BlinnPhong& s) {
  check_range("color", s.color, channel_range);
  check(s.phong);
}
void check(const Textured&) {}
void check(const Bump& s) {
  check_range("color", s.color, channel_range);
  check(s.phong);
  check_range("height_scaling", s.height_scaling, height_range);
  check_range("normal_scaling", s.normal_scaling, scaling);
}
void check(const Mirror&) {}
void check(const PhongTexture& s) { check(s.phong); }
void check(const Translucent& s) {
  check(s.phong);
  check_range("alpha", s.alpha, channel_range);
}
void check(const Cartoon& s) {
  check_range("color", s.color, channel_range);
  check_range("kd", s.kd, coefficient);
  check_range("levels", s.levels, level_count);
  check_range("ambient", s.ambient, coefficient);
}

template <class Pointer>
void require_loaded(const Pointer& pointer, const char* key, const char* expected) {
  if (!pointer) throw InvalidValue({key}, "nothing", expected);
}

struct CheckImages {
  template <class Kind>
  void operator()(const Kind&) const {}
  void operator()(const Textured& s) const { check_texture(s.image); }
  void operator()(const PhongTexture& s) const { check_texture(s.image); }
  void operator()(const Translucent& s) const { check_texture(s.image); }
  void operator()(const Bump& s) const { check_height_map(s); }
  void operator()(const Displacement& s) const { check_height_map(s); }
  void operator()(const Mirror& s) const {
    require_loaded(s.environment, "environment", "a folder of six images, or a panorama");
  }

 private:
  static void check_texture(const std::shared_ptr<const Image>& image) {
    require_loaded(image, "texture", "an image file");
  }
  static void check_height_map(const Bump& s) {
    require_loaded(s.height_map, "height_map", "an image file");
  }
};

/// Calls f with a default value of each alternative of Shading.
template <class F, std::size_t... I>
void for_each_shading(F&& f, std::index_sequence<I...>) {
  (f(std::variant_alternative_t<I, Shading>{}), ...);
}

template <class F>
void for_each_shading(F&& f) {
  for_each_shading(f, std::make_index_sequence<std::variant_size_v<Shading>>{});
}

}  // namespace

const char* shading_name(const Shading& shading) {
  return std::visit([](const auto& s) { return std::decay_t<decltype(s)>::name; }, shading);
}

std::vector<std::string> shading_names() {
  std::vector<std::string> names;
  for_each_shading([&](const auto& s) { names.push_back(s.name); });
  return names;
}

Shading make_shading(const std::string& name) {
  Shading result;
  bool found = false;
  std::string known;
  for_each_shading([&](const auto& s) {
    known += (known.empty() ? "" : ", ") + std::string(s.name);
    if (name != s.name) return;
    result = s;
    found = true;
  });
  if (!found) throw InvalidValue({"shader"}, name, "one of " + known);
  return result;
}

void validate(const Shading& shading) {
  std::visit(CheckImages{}, shading);
  validate_numbers(shading);
}

void validate_numbers(const Shading& shading) {
  std::visit([](const auto& s) { check(s); }, shading);
}

}  // namespace clothsim
