#include "clothsim/view/video.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string>

#include "clothsim/model/checks.h"

extern char** environ;

namespace clothsim {

Video::Video(const std::filesystem::path& path, int width, int height, double rate) : path_(path) {
  std::signal(SIGPIPE, SIG_IGN);  // write() reports that ffmpeg has ended
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::strerror(errno));
  pipe_ = ends[1];

  // Most players need an even number of pixels, as four of them share a colour.
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  const std::vector<std::string> words = {"ffmpeg",
                                          "-y",
                                          "-loglevel",
                                          "error",
                                          "-f",
                                          "rawvideo",
                                          "-pixel_format",
                                          "rgb24",
                                          "-video_size",
                                          size,
                                          "-framerate",
                                          to_text(rate),
                                          "-i",
                                          "pipe:0",
                                          "-vf",
                                          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                          "-pix_fmt",
                                          "yuv420p",
                                          "file:" + path.string()};
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  // In a process group of its own: a terminal's SIGINT ends the run, and then the video is
  // completed.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int error =
      posix_spawnp(&ffmpeg_, "ffmpeg", &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[0]);
  if (error == 0) return;
  close(pipe_);
  throw std::runtime_error(std::string("cannot run ffmpeg for a video: ") + std::strerror(error));
}

Video::~Video() { end(); }

void Video::append(const std::vector<std::uint8_t>& rgb) {
  for (std::size_t done = 0; done < rgb.size();) {
    const ssize_t count = write(pipe_, rgb.data() + done, rgb.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      throw std::runtime_error("cannot write " + path_.string() + ": ffmpeg has ended");
    done += static_cast<std::size_t>(count);
  }
}

void Video::finish() {
  if (!end()) throw std::runtime_error("cannot write " + path_.string() + ": ffmpeg failed");
}

bool Video::end() {
  if (pipe_ < 0) return true;
  close(pipe_);
  pipe_ = -1;
  int status = 0;
  while (waitpid(ffmpeg_, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace clothsim
