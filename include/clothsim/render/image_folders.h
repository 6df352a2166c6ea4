#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace clothsim {

/// Folders that images may come from, including their subfolders.
class ImageFolders {
 public:
  /// Any folder.
  ImageFolders() = default;

  /// These folders only.
  explicit ImageFolders(const std::vector<std::string>& folders);

  /// The path of an image without links, "." and "..". Throws InvalidValue with `key` where it is
  /// in none of the folders, even if it does not exist.
  std::string resolve(const std::string& path, const std::string& key) const;

 private:
  std::optional<std::vector<std::filesystem::path>> folders_;
};

}  // namespace clothsim
