#pragma once

#include <stdexcept>

namespace clothsim {

/// OpenGL refused something: a fault of ours or of the driver, or memory that ran out.
class GlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace clothsim
