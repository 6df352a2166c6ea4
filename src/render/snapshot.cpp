#include "clothsim/render/snapshot.h"

#include "ranges.h"

namespace clothsim {
namespace {

constexpr Range intensity{0, 1e6, ""};
constexpr Range segment_count{3, 512, ""};  // at most half a million triangles
constexpr Range plane_side{1e-3, 1e4, "m"};

}  // namespace

void validate(const Light& light) {
  check_range("position", light.position, coordinate_range);
  check_range("intensity", light.intensity, intensity);
  check_range("ambient", light.ambient, intensity);
}

void validate(const Background& background) {
  check_range("background", background.color, channel_range);
}

void validate(const ColliderView& view) {
  check_range("segments", view.segments, segment_count);
  check_range("extent", view.extent, plane_side);
  validate(view.shading);
}

}  // namespace clothsim
