#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace clothsim {

/// No OpenGL context could be made. `what()` lists the attempts and why each failed.
class NoContext : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One line for each EGL device of the machine, in the order of their index.
std::vector<std::string> egl_devices();

/// Throws InvalidValue with the key {"egl_device"} for an index that does not exist. Where EGL has
/// no devices at all, the index is not at fault: the error comes when a context is made.
void check_egl_device(int index);

/// An OpenGL 3.3 core context without window or display server, current in the thread that makes
/// it. Use and destroy it in that thread.
class EglContext {
 public:
  /// Tries hardware devices first, then software ones, then Mesa's surfaceless platform; with a
  /// `device` only that index of egl_devices(). Throws NoContext, and the errors of
  /// check_egl_device().
  explicit EglContext(std::optional<int> device = std::nullopt);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// Makes it current again where another context may have been used in the thread since. Cheap.
  void make_current() const;

  /// The context's device, and the names of its renderer and version.
  const std::string& description() const { return description_; }

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
  std::string description_;
};

}  // namespace clothsim
