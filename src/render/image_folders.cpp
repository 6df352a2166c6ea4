#include "clothsim/render/image_folders.h"

#include <algorithm>

#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

/// Empty where the path cannot be followed, for example as a name in it is too long.
fs::path without_links(const std::string& path) {
  std::error_code error;
  const fs::path resolved = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? fs::path() : resolved;
}

bool is_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
         folder.end();
}

}  // namespace

ImageFolders::ImageFolders(const std::vector<std::string>& folders) : folders_(std::in_place) {
  for (const std::string& folder : folders) folders_->push_back(without_links(folder));
}

std::string ImageFolders::resolve(const std::string& path, const std::string& key) const {
  if (!folders_) return path;
  const fs::path resolved = without_links(path);
  std::vector<std::string> names;
  for (const fs::path& folder : *folders_) {
    if (!resolved.empty() && !folder.empty() && is_below(resolved, folder)) return resolved;
    names.push_back(folder);
  }
  throw InvalidValue({key}, '"' + path + '"', "an image in one of image_folders: " + join(names));
}

}  // namespace clothsim
