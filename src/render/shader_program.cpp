#include "clothsim/render/shader_program.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <sstream>

namespace clothsim {
namespace {

/// Appends `name` to `source`, unless it is included already.
void append_file(const std::string& folder, const std::string& name, const std::string& asked_by,
                 std::set<std::string>& seen, ShaderSource& source) {
  if (!seen.insert(name).second) return;
  std::ifstream file(folder + "/" + name);
  if (!file) {
    throw ShaderError("shader " + folder + "/" + name + " cannot be read" +
                      (asked_by.empty() ? "" : "; " + asked_by + " includes it"));
  }

  static const std::regex include("\\s*#include\\s+\"([^\"]+)\"\\s*");
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    std::smatch match;
    if (std::regex_match(line, match, include)) {
      append_file(folder, match[1], name + ":" + std::to_string(number), seen, source);
    } else {
      source.text += line + "\n";
      source.origins.push_back({name, number});
    }
  }
}

/// The driver's log with line numbers of the whole text replaced by file and line: Mesa writes
/// "0:7(3): error", NVIDIA "0(7) : error". (Mesa ignores the file number of a #line.)
std::string readable_log(const std::string& log, const std::vector<ShaderSource::Line>& origins) {
  static const std::regex position(R"(^(?:ERROR: )?\d+[:(](\d+)\)?)");
  std::istringstream lines(log);
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_search(line, match, position)) {
      const std::size_t number = std::stoul(match[1]);
      if (number >= 1 && number <= origins.size()) {
        const ShaderSource::Line& origin = origins[number - 1];
        line = origin.file + ":" + std::to_string(origin.number) + match.suffix().str();
      }
    }
    text += "\n  " + line;
  }
  return text;
}

template <class Object>
std::string info_log(const Object& object, void (*get_length)(GLuint, GLint*),
                     const std::function<void(GLuint, GLsizei, GLchar*)>& get_log) {
  GLint length = 0;
  get_length(object.id(), &length);
  std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
  get_log(object.id(), length, log.data());
  return log.c_str();
}

template <GLenum stage>
GlHandle<ShaderKind<stage>> compile(const std::string& folder, const std::string& name,
                                    const std::string& define) {
  ShaderSource source = read_shader(folder, name);
  if (!define.empty()) {  // after #version, which must be first
    source.text.insert(source.text.find('\n') + 1, "#define " + define + '\n');
    source.origins.insert(source.origins.begin() + 1, source.origins.front());
  }
  GlHandle<ShaderKind<stage>> shader;
  const char* text = source.text.c_str();
  glShaderSource(shader.id(), 1, &text, nullptr);
  glCompileShader(shader.id());
  GLint fine = 0;
  glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &fine);
  if (!fine) {
    const std::string log = info_log(
        shader, [](GLuint id, GLint* length) { glGetShaderiv(id, GL_INFO_LOG_LENGTH, length); },
        [](GLuint id, GLsizei size, GLchar* out) { glGetShaderInfoLog(id, size, nullptr, out); });
    throw ShaderError("shader " + folder + "/" + name +
                      " does not compile:" + readable_log(log, source.origins));
  }
  return shader;
}

}  // namespace

ShaderSource read_shader(const std::string& folder, const std::string& name) {
  ShaderSource source;
  std::set<std::string> seen;
  append_file(folder, name, "", seen, source);
  return source;
}

ShaderProgram::ShaderProgram(const std::string& folder, const std::string& vertex,
                             const std::string& fragment, const std::string& define) {
  const auto vertex_shader = compile<GL_VERTEX_SHADER>(folder, vertex, "");
  const auto fragment_shader = compile<GL_FRAGMENT_SHADER>(folder, fragment, define);
  glAttachShader(program_.id(), vertex_shader.id());
  glAttachShader(program_.id(), fragment_shader.id());
  glLinkProgram(program_.id());
  GLint fine = 0;
  glGetProgramiv(program_.id(), GL_LINK_STATUS, &fine);
  if (!fine) {
    const std::string log = info_log(
        program_, [](GLuint id, GLint* length) { glGetProgramiv(id, GL_INFO_LOG_LENGTH, length); },
        [](GLuint id, GLsizei size, GLchar* out) { glGetProgramInfoLog(id, size, nullptr, out); });
    throw ShaderError("shaders " + vertex + " and " + fragment + " in " + folder +
                      " do not link:\n  " + log);
  }
  glDetachShader(program_.id(), vertex_shader.id());
  glDetachShader(program_.id(), fragment_shader.id());

  // Look up every uniform once.
  GLint count = 0, longest = 0;
  glGetProgramiv(program_.id(), GL_ACTIVE_UNIFORMS, &count);
  glGetProgramiv(program_.id(), GL_ACTIVE_UNIFORM_MAX_LENGTH, &longest);
  std::string name(static_cast<std::size_t>(std::max(longest, 1)), '\0');
  for (GLint i = 0; i < count; ++i) {
    GLint size = 0;
    GLenum type = 0;
    glGetActiveUniform(program_.id(), static_cast<GLuint>(i), longest, nullptr, &size, &type,
                       name.data());
    locations_[name.c_str()] = glGetUniformLocation(program_.id(), name.c_str());
  }

  // The block of all shaders is binding 0; it is absent where it is unused.
  const GLuint block = glGetUniformBlockIndex(program_.id(), "Frame");
  if (block != GL_INVALID_INDEX) glUniformBlockBinding(program_.id(), block, 0);
}

int ShaderProgram::location(const char* name) const {
  const auto found = locations_.find(std::string_view(name));
  return found == locations_.end() ? -1 : found->second;
}

void ShaderProgram::set(const char* name, int value) const { glUniform1i(location(name), value); }

void ShaderProgram::set(const char* name, double value) const {
  glUniform1f(location(name), static_cast<float>(value));
}

void ShaderProgram::set(const char* name, const Eigen::Vector3d& value) const {
  const Eigen::Vector3f v = value.cast<float>();
  glUniform3fv(location(name), 1, v.data());
}

void ShaderProgram::set(const char* name, const Eigen::Matrix3d& value) const {
  const Eigen::Matrix3f m = value.cast<float>();
  glUniformMatrix3fv(location(name), 1, GL_FALSE, m.data());
}

}  // namespace clothsim
