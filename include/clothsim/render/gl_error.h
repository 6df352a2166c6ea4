#pragma once

#include <stdexcept>

namespace clothsim {

/// An error of OpenGL: a bug here or in the driver, or a lack of memory.
class GlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace clothsim
