#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "clothsim/render/image.h"

namespace clothsim {

/// The images of a view, each read from its file once, and again when the file has changed. A path
/// is taken as given, or else as the name of one of the package's own textures. sweep() drops
/// images that were not requested since the last sweep().
class ImageStore {
 public:
  explicit ImageStore(std::string textures_folder, ImageFolders folders = {})
      : folder_(std::move(textures_folder)), folders_(std::move(folders)) {}

  /// Throw InvalidValue with `key` for a file that is missing, broken or not in the folders.
  std::shared_ptr<const Image> image(const std::string& path, const std::string& key);
  std::shared_ptr<const HeightMap> height_map(const std::string& path, const std::string& key);
  std::shared_ptr<const CubeMap> cube_map(const std::string& path, const std::string& key);

  void sweep();

 private:
  template <class Kind>
  struct Entry {
    std::filesystem::file_time_type time;
    std::shared_ptr<const Kind> value;
    bool used = true;
  };
  template <class Kind>
  using Entries = std::map<std::string, Entry<Kind>>;

  template <class Kind, class Load>
  std::shared_ptr<const Kind> get(Entries<Kind>&, const std::string& path, const std::string& key,
                                  Load load);

  std::string folder_;
  ImageFolders folders_;  // allowed folders of other images
  Entries<Image> images_;
  Entries<HeightMap> height_maps_;
  Entries<CubeMap> cube_maps_;
};

}  // namespace clothsim
