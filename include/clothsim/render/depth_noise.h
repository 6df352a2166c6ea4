#pragma once

#include <cstdint>
#include <vector>

namespace clothsim {

/// Random error of a depth camera that triangulates: normal, of standard deviation sigma z^2 at
/// depth z in metres, independent in each pixel. Khoshelham & Elberink 2012, "Accuracy and
/// resolution of Kinect depth data for indoor mapping applications": 1.425e-3 m for a Kinect.
struct DepthNoise {
  double sigma = 0;  // [m] at a depth of 1 m; 0: none
  std::uint64_t seed = 0;
};

/// Throws InvalidValue, with keys such as {"sigma"}.
void validate(const DepthNoise&);

/// Adds the error to finite depths [m], which stay at `nearest` or more. The error is a function of
/// the noise with its seed, the time [s] and the pixel.
void add_noise(const DepthNoise&, double time, double nearest, std::vector<float>& depth);

}  // namespace clothsim
