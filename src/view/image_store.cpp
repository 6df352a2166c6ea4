#include "clothsim/view/image_store.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace clothsim {

namespace fs = std::filesystem;

namespace {

/// Time of the last change of a file; for a folder, of one of its files.
fs::file_time_type last_change(const fs::path& path) {
  std::error_code ignored;
  fs::file_time_type last = fs::last_write_time(path, ignored);
  for (const fs::directory_entry& file : fs::directory_iterator(path, ignored))
    last = std::max(last, file.last_write_time(ignored));
  return last;
}

template <class Entries>
void drop_unused(Entries& entries) {
  for (auto entry = entries.begin(); entry != entries.end();)
    entry = std::exchange(entry->second.used, false) ? std::next(entry) : entries.erase(entry);
}

}  // namespace

template <class Kind, class Load>
std::shared_ptr<const Kind> ImageStore::get(Entries<Kind>& entries, const std::string& path,
                                            const std::string& key, Load load) {
  // A path that cannot be read, for example as it is too long, is left to `load` to refuse.
  std::error_code ignored;
  const fs::path own = fs::path(folder_) / path;
  const bool is_own = !fs::exists(path, ignored) && fs::exists(own, ignored);
  const std::string file = folders_.resolve(is_own ? own.string() : path, key);

  const fs::file_time_type time = last_change(file);
  const auto known = entries.find(file);
  if (known != entries.end() && known->second.time == time) {
    known->second.used = true;
    return known->second.value;
  }
  return (entries[file] = {time, load(file, key, folders_)}).value;
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

void ImageStore::sweep() {
  drop_unused(images_);
  drop_unused(height_maps_);
  drop_unused(cube_maps_);
}

}  // namespace clothsim
