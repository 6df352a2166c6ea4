#include "clothsim/model/files.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace clothsim {
namespace {

/// The error message; empty: success.
std::string failure_to_write(const std::filesystem::path& path, const std::string& contents) {
  errno = 0;
  std::ofstream file(path, std::ios::binary);
  file.write(contents.data(), static_cast<std::streamsize>(contents.size()));
  file.close();
  return file ? "" : std::strerror(errno);
}

}  // namespace

void write_file(const std::filesystem::path& path, const std::string& contents) {
  std::filesystem::path beside = path;
  beside += ".part";
  std::error_code error, ignored;
  std::string failure = failure_to_write(beside, contents);
  if (failure.empty()) {
    std::filesystem::rename(beside, path, error);
    if (!error) return;
    failure = error.message();
  }
  std::filesystem::remove(beside, ignored);
  throw std::runtime_error("cannot write " + path.string() + ": " + failure);
}

}  // namespace clothsim
