#include "clothsim/render/texture_cache.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace clothsim {
namespace {

/// Rows from bottom to top, as OpenGL expects for v upwards.
template <class Value>
std::vector<Value> flip_rows(const std::vector<Value>& values, int height) {
  const std::size_t rows = static_cast<std::size_t>(height), row_size = values.size() / rows;
  std::vector<Value> flipped(values.size());
  for (std::size_t row = 0; row < rows; ++row) {
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(row * row_size), row_size,
                flipped.end() - static_cast<std::ptrdiff_t>((row + 1) * row_size));
  }
  return flipped;
}

void set_filter(GLenum target, GLint wrap) {
  glTexParameteri(target, GL_TEXTURE_WRAP_S, wrap);
  glTexParameteri(target, GL_TEXTURE_WRAP_T, wrap);
  glTexParameteri(target, GL_TEXTURE_WRAP_R, wrap);
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glGenerateMipmap(target);
}

void upload_rgb(GLenum target, const Image& image, const std::uint8_t* rgb) {
  glTexImage2D(target, 0, GL_SRGB8, image.width, image.height, 0, GL_RGB, GL_UNSIGNED_BYTE, rgb);
}

}  // namespace

template <class Source, class Upload>
void TextureCache::bind(const std::shared_ptr<const Source>& source, int unit, GLenum target,
                        Upload upload) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  const auto known = entries_.find(source.get());
  if (known != entries_.end()) {
    known->second.used = true;
    glBindTexture(target, known->second.texture.id());
    return;
  }
  Entry entry;
  entry.source = source;
  glBindTexture(target, entry.texture.id());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  upload(*source);
  check_gl("uploading an image");
  entries_.emplace(source.get(), std::move(entry));
}

void TextureCache::bind(const std::shared_ptr<const Image>& image, int unit) {
  bind(image, unit, GL_TEXTURE_2D, [](const Image& i) {
    upload_rgb(GL_TEXTURE_2D, i, flip_rows(i.rgb, i.height).data());
    set_filter(GL_TEXTURE_2D, GL_REPEAT);
  });
}

void TextureCache::bind(const std::shared_ptr<const HeightMap>& map, int unit) {
  bind(map, unit, GL_TEXTURE_2D, [](const HeightMap& m) {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, m.width, m.height, 0, GL_RED, GL_FLOAT,
                 flip_rows(m.heights, m.height).data());
    set_filter(GL_TEXTURE_2D, GL_REPEAT);
  });
}

void TextureCache::bind(const std::shared_ptr<const CubeMap>& cube, int unit) {
  bind(cube, unit, GL_TEXTURE_CUBE_MAP, [](const CubeMap& c) {
    for (std::size_t i = 0; i < c.faces.size(); ++i) {
      upload_rgb(GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(i), c.faces[i],
                 c.faces[i].rgb.data());
    }
    set_filter(GL_TEXTURE_CUBE_MAP, GL_CLAMP_TO_EDGE);
  });
}

void TextureCache::sweep() {
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (entry->second.used) {
      entry->second.used = false;
      ++entry;
    } else {
      entry = entries_.erase(entry);
    }
  }
}

}  // namespace clothsim
