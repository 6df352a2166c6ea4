#include "clothsim/render/depth_noise.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

constexpr Range deviation{0, 1, "m"};

/// Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators": SplitMix64's mixing
/// of a counter.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

/// A uniform number in (0, 1].
double uniform(std::uint64_t bits) { return static_cast<double>((bits >> 11) + 1) * 0x1p-53; }

/// A number from the standard normal distribution (Box & Muller 1958).
double normal(std::uint64_t bits) {
  return std::sqrt(-2 * std::log(uniform(bits))) * std::cos(2 * M_PI * uniform(mixed(bits)));
}

}  // namespace

void validate(const DepthNoise& noise) { check_range("sigma", noise.sigma, deviation); }

void add_noise(const DepthNoise& noise, double time, double nearest, std::vector<float>& depth) {
  if (noise.sigma == 0) return;
  std::uint64_t moment = 0;
  std::memcpy(&moment, &time, sizeof(moment));
  const std::uint64_t picture = mixed(noise.seed + mixed(moment));
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const auto z = static_cast<double>(depth[i]);
    if (!std::isfinite(z)) continue;
    const double error = noise.sigma * z * z * normal(mixed(picture + i));
    depth[i] = static_cast<float>(std::max(nearest, z + error));
  }
}

}  // namespace clothsim
