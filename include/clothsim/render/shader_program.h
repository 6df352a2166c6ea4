#pragma once

#include <Eigen/Core>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// A shader that cannot be read, compiled or linked. `what()` names file and line.
class ShaderError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The text of a shader with each line `#include "name"` replaced by that file of the same folder,
/// once. Line i of the text, counted from 0, is origins[i].
struct ShaderSource {
  struct Line {
    std::string file;
    int number;
  };
  std::string text;
  std::vector<Line> origins;
};

/// Throws ShaderError for a file that is missing.
ShaderSource read_shader(const std::string& folder, const std::string& name);

/// A compiled and linked pair of a vertex and a fragment shader.
class ShaderProgram {
 public:
  /// Reads both from `folder`. `define`: a macro for the fragment shader; empty: none. Throws
  /// ShaderError.
  ShaderProgram(const std::string& folder, const std::string& vertex, const std::string& fragment,
                const std::string& define = "");

  void use() const { glUseProgram(program_.id()); }

  /// Set a uniform of the program in use; names that the shaders do not have are ignored.
  void set(const char* name, int value) const;
  void set(const char* name, double value) const;
  void set(const char* name, const Eigen::Vector3d& value) const;
  void set(const char* name, const Eigen::Matrix3d& value) const;

 private:
  int location(const char* name) const;

  Program program_;
  std::map<std::string, int, std::less<>> locations_;
};

}  // namespace clothsim
