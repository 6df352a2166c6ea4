#include "clothsim/simulation/output.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace clothsim {
namespace {

template <class Number>
void append_bytes(Number value, std::string& bytes) {
  std::array<char, sizeof(Number)> raw;
  std::memcpy(raw.data(), &value, sizeof(Number));
  bytes.append(raw.data(), raw.size());
}

}  // namespace

std::string to_csv(const State& state) {
  std::string text = "x,y,z,vx,vy,vz\n";
  std::array<char, 200> line;
  for (Eigen::Index i = 0; i < state.positions.rows(); ++i) {
    const auto x = state.positions.row(i);
    const auto v = state.velocities.row(i);
    const int length =
        std::snprintf(line.data(), line.size(), "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", x[0], x[1],
                      x[2], v[0], v[1], v[2]);
    text.append(line.data(), static_cast<size_t>(length));
  }
  return text;
}

std::string to_ply(const Cloth& cloth, const Points& positions) {
  constexpr bool little = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
  std::string ply = std::string("ply\nformat ") +
                    (little ? "binary_little_endian" : "binary_big_endian") +
                    " 1.0\nelement vertex " + std::to_string(positions.rows()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                    std::to_string(cloth.triangles.size()) +
                    "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    for (int axis = 0; axis < 3; ++axis) append_bytes(static_cast<float>(positions(i, axis)), ply);
  }
  for (const auto& triangle : cloth.triangles) {
    append_bytes<std::uint8_t>(3, ply);
    for (const int point : triangle) append_bytes<std::int32_t>(point, ply);
  }
  return ply;
}

}  // namespace clothsim
