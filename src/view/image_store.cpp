#include "clothsim/view/image_store.h"

namespace clothsim {

namespace fs = std::filesystem;

template <class Kind, class Load>
std::shared_ptr<const Kind> ImageStore::get(Entries<Kind>& entries, const std::string& path,
                                            const std::string& key, Load load) {
  std::error_code no_such_file;
  const bool own = !fs::exists(path, no_such_file) && fs::exists(fs::path(folder_) / path);
  const std::string file = own ? (fs::path(folder_) / path).string() : path;

  const auto time = fs::last_write_time(file, no_such_file);
  const auto known = entries.find(file);
  if (known != entries.end() && known->second.time == time) return known->second.value;
  return (entries[file] = {time, load(file, key)}).value;
}

std::shared_ptr<const Image> ImageStore::image(const std::string& path, const std::string& key) {
  return get(images_, path, key, load_image);
}

std::shared_ptr<const HeightMap> ImageStore::height_map(const std::string& path,
                                                        const std::string& key) {
  return get(height_maps_, path, key, load_height_map);
}

std::shared_ptr<const CubeMap> ImageStore::cube_map(const std::string& path,
                                                    const std::string& key) {
  return get(cube_maps_, path, key, load_cube_map);
}

}  // namespace clothsim
