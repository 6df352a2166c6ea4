#include "clothsim/render/egl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glew.h>

#include <cstring>
#include <sstream>

#include "clothsim/model/errors.h"
#include "clothsim/render/gl_error.h"

namespace clothsim {
namespace {

/// A source of a display: an EGL device, or a platform without one (device null).
struct Candidate {
  std::string name;
  EGLenum platform;
  EGLDeviceEXT device;
};

bool has_extension(const char* list, const char* name) {
  if (!list) return false;
  std::istringstream words(list);
  for (std::string word; words >> word;)
    if (word == name) return true;
  return false;
}

template <class Function>
Function load(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

std::vector<EGLDeviceEXT> query_devices() {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto query = load<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  if (!has_extension(extensions, "EGL_EXT_platform_device") || !query) return {};
  EGLint count = 0;
  if (!query(0, nullptr, &count)) return {};
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  if (!query(count, devices.data(), &count)) return {};
  devices.resize(static_cast<std::size_t>(count));
  return devices;
}

std::string query_device_string(EGLDeviceEXT device, EGLint name) {
  const auto query = load<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const char* text = query ? query(device, name) : nullptr;
  return text ? text : "";
}

bool is_software(EGLDeviceEXT device) {
  return has_extension(query_device_string(device, EGL_EXTENSIONS).c_str(),
                       "EGL_MESA_device_software");
}

std::string device_name(std::size_t index, EGLDeviceEXT device) {
  std::string name = "EGL device " + std::to_string(index);
  if (is_software(device)) return name + " (software)";
  const std::string extensions = query_device_string(device, EGL_EXTENSIONS);
  const bool has_file = has_extension(extensions.c_str(), "EGL_EXT_device_drm");
  const std::string file = has_file ? query_device_string(device, EGL_DRM_DEVICE_FILE_EXT) : "";
  return name + (file.empty() ? " (hardware)" : " (hardware, " + file + ")");
}

/// The candidates, best first.
std::vector<Candidate> candidates(std::optional<int> only) {
  const std::vector<EGLDeviceEXT> devices = query_devices();
  const auto at = [&](std::size_t i) {
    return Candidate{device_name(i, devices[i]), EGL_PLATFORM_DEVICE_EXT, devices[i]};
  };
  if (only) {
    check_egl_device(*only);
    if (devices.empty()) return {};
    return {at(static_cast<std::size_t>(*only))};
  }

  std::vector<Candidate> list;
  for (const bool software : {false, true}) {
    for (std::size_t i = 0; i < devices.size(); ++i)
      if (is_software(devices[i]) == software) list.push_back(at(i));
  }
  if (has_extension(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS),
                    "EGL_MESA_platform_surfaceless"))
    list.push_back({"Mesa's surfaceless platform", EGL_PLATFORM_SURFACELESS_MESA, nullptr});
  return list;
}

/// Why the last EGL call failed.
std::string egl_failure(const char* call) {
  std::ostringstream text;
  text << call << " failed with EGL error 0x" << std::hex << eglGetError();
  return text.str();
}

/// Loads OpenGL's functions. Debian builds GLEW for GLX: without an X display glewInit() loads
/// every function and then reports that there is no GLX display.
std::string load_functions() {
  const GLenum result = glewInit();
  if (result != GLEW_OK && result != GLEW_ERROR_NO_GLX_DISPLAY)
    return std::string("GLEW: ") + reinterpret_cast<const char*>(glewGetErrorString(result));
  if (!GLEW_VERSION_3_3 || !glGenVertexArrays) return "GLEW found no OpenGL 3.3";
  return "";
}

/// Makes a context current. Returns the error, or an empty text.
std::string open(const Candidate& candidate, void*& display, void*& context) {
  const auto get_display = load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (!get_display) return "EGL has no eglGetPlatformDisplayEXT";
  display = get_display(candidate.platform, candidate.device, nullptr);
  if (display == EGL_NO_DISPLAY) return egl_failure("eglGetPlatformDisplayEXT");
  if (!eglInitialize(display, nullptr, nullptr)) return egl_failure("eglInitialize");
  if (!eglBindAPI(EGL_OPENGL_API)) return egl_failure("eglBindAPI(EGL_OPENGL_API)");

  // All drawing goes to framebuffer objects, so any config with OpenGL will do.
  const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &count)) return egl_failure("eglChooseConfig");
  if (count == 0) return "no EGL config with OpenGL";

  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            3,
                            EGL_CONTEXT_MINOR_VERSION,
                            3,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
  context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
  if (context == EGL_NO_CONTEXT) return egl_failure("eglCreateContext (OpenGL 3.3 core)");
  std::string failure;
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
    failure = egl_failure("eglMakeCurrent without a surface");
  if (failure.empty()) failure = load_functions();
  if (!failure.empty()) {
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
  }
  return failure;
}

std::string gl_string(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text ? reinterpret_cast<const char*>(text) : "unknown";
}

}  // namespace

std::vector<std::string> egl_devices() {
  const std::vector<EGLDeviceEXT> devices = query_devices();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < devices.size(); ++i) names.push_back(device_name(i, devices[i]));
  return names;
}

void check_egl_device(int index) {
  const std::size_t count = query_devices().size();
  const bool exists = index >= 0 && (count == 0 || static_cast<std::size_t>(index) < count);
  if (!exists) {
    throw InvalidValue({"egl_device"}, std::to_string(index),
                       "an index from 0 to " + std::to_string(count == 0 ? 0 : count - 1) +
                           " of this machine's EGL devices");
  }
}

EglContext::EglContext(std::optional<int> device) {
  std::string tried;
  for (const Candidate& candidate : candidates(device)) {
    const std::string failure = open(candidate, display_, context_);
    if (failure.empty()) {
      description_ =
          candidate.name + ", " + gl_string(GL_RENDERER) + ", OpenGL " + gl_string(GL_VERSION);
      return;
    }
    tried += "\n  " + candidate.name + ": " + failure;
  }
  throw NoContext("no OpenGL context without a display; tried:" +
                  (tried.empty() ? "\n  nothing: EGL offers neither devices nor Mesa's "
                                   "surfaceless platform"
                                 : tried));
}

EglContext::~EglContext() {
  // The display belongs to the whole process: another thread may be using it, so it stays.
  if (eglGetCurrentContext() == context_)
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

void EglContext::make_current() const {
  if (eglGetCurrentContext() == context_) return;
  if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
    throw GlError(egl_failure("eglMakeCurrent"));
}

}  // namespace clothsim
