#include "clothsim/view/image_store.h"

namespace clothsim {

namespace fs = std::filesystem;

template <class Kind, class Load>
std::shared_ptr<const Kind> ImageStore::get(Entries<Kind>& entries, const std::string& path,
                                            const std::string& key, Load load) {
  // A path that cannot be looked at, say since it is too long, is left to `load` to refuse.
  std::error_code ignored;
  const fs::path own = fs::path(folder_) / path;
  const bool is_own = !fs::exists(path, ignored) && fs::exists(own, ignored);
  const std::string file = is_own ? own.string() : path;

  const auto time = fs::last_write_time(file, ignored);
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
