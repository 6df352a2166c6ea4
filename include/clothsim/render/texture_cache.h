#pragma once

#include <map>
#include <memory>

#include "clothsim/render/gl_handles.h"
#include "clothsim/render/image.h"

namespace clothsim {

/// The textures of images, uploaded when first requested. sweep() drops those that were not
/// requested since the last sweep().
class TextureCache {
 public:
  /// Binds the image's texture to a unit. Colours become linear when read, heights are linear.
  /// Throw GlError where the driver refuses the image.
  void bind(const std::shared_ptr<const Image>&, int unit);
  void bind(const std::shared_ptr<const HeightMap>&, int unit);
  void bind(const std::shared_ptr<const CubeMap>&, int unit);

  void sweep();

 private:
  struct Entry {
    Texture texture;
    std::shared_ptr<const void> source;  // keeps its address from being reused
    bool used = true;
  };

  template <class Source, class Upload>
  void bind(const std::shared_ptr<const Source>&, int unit, GLenum target, Upload upload);

  std::map<const void*, Entry> entries_;
};

}  // namespace clothsim
