#include "clothsim/view/resources.h"

namespace clothsim {

std::string shaders_folder() { return package_folder("shaders"); }
std::string textures_folder() { return package_folder("config/textures"); }

}  // namespace clothsim
