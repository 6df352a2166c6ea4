#pragma once

#include "clothsim/render/image.h"
#include "clothsim/render/renderer.h"
#include "clothsim/view/image_store.h"
#include "clothsim/view/snapshot_maker.h"

namespace clothsim {

/// Draws pictures of scenes, and keeps the renderer and the images between them.
class PictureMaker {
 public:
  /// Uses the device of the first view. Throws as Renderer does.
  explicit PictureMaker(const View& first);

  /// The wanted images of the present state, valid until the next call. Throws as prepare() and
  /// Renderer::render() do.
  const Images& draw(const Simulator&, const View&, const WantedImages&);

 private:
  ImageStore images_;
  Renderer renderer_;
  SnapshotMaker snapshots_;
  Images drawn_;
};

}  // namespace clothsim
