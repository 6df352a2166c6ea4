#include "clothsim/view/picture_maker.h"

#include "clothsim/view/resources.h"

namespace clothsim {

PictureMaker::PictureMaker(const View& first)
    : images_(textures_folder()),
      renderer_({shaders_folder(), first.egl_device, first.samples, false}) {}

const Images& PictureMaker::draw(const Simulator& simulator, const View& view,
                                 const WantedImages& wanted) {
  const PreparedView ready = prepare(view, images_);
  renderer_.render(snapshots_.make(simulator, ready), ready.camera, wanted, drawn_);
  return drawn_;
}

}  // namespace clothsim
