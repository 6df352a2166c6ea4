#include "clothsim/render/snapshot.h"

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

constexpr Range coordinate{-1e6, 1e6, "m"};
constexpr Range intensity{0, 1e6, ""};
constexpr Range channel{0, 1, ""};
constexpr Range segment_count{3, 512, ""};  // at most half a million triangles
constexpr Range side{1e-3, 1e4, "m"};

}  // namespace

void validate(const Light& light) {
  check_range("position", light.position, coordinate);
  check_range("intensity", light.intensity, intensity);
  check_range("ambient", light.ambient, intensity);
}

void validate(const Background& background) {
  check_range("background", background.color, channel);
}

void validate(const ColliderView& view) {
  check_range("segments", view.segments, segment_count);
  check_range("extent", view.extent, side);
  validate(view.shading);
}

}  // namespace clothsim
