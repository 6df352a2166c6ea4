#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace clothsim {

/// Folders that images may come from, with all that is below them.
class ImageFolders {
 public:
  /// From anywhere.
  ImageFolders() = default;

  /// From these alone.
  explicit ImageFolders(const std::vector<std::string>& folders);

  /// The path of an image without links, "." and "..". Throws InvalidValue with `key` where that is
  /// in none of the folders, whether it exists or not.
  std::string resolve(const std::string& path, const std::string& key) const;

 private:
  std::optional<std::vector<std::filesystem::path>> folders_;
};

}  // namespace clothsim
