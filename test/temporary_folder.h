#pragma once

#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace clothsim::test {

/// A new folder of a test's own, removed at the end with all its contents.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& name) {
    std::string path = ::testing::TempDir() + name + "_" + std::string(6, 'X');  // for mkdtemp
    if (!mkdtemp(path.data())) throw std::system_error(errno, std::generic_category(), path);
    path_ = path;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace clothsim::test
