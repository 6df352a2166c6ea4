#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace clothsim {

/// A video file. ffmpeg encodes it during the run, so that no pictures wait on disk.
class Video {
 public:
  /// width x height: size of the pictures in pixels; `rate` [Hz]; the extension gives the format,
  /// as .mp4. Throws std::runtime_error without ffmpeg.
  Video(const std::filesystem::path& path, int width, int height, double rate);

  /// Without finish() ffmpeg ends the video with the pictures so far.
  ~Video();
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  /// Bytes r, g, b of each pixel, top row first. Throws std::runtime_error where ffmpeg has ended.
  void append(const std::vector<std::uint8_t>& rgb);

  /// Waits for the file to be complete. Throws std::runtime_error where ffmpeg fails; ffmpeg has
  /// printed the reason then.
  void finish();

 private:
  bool end();

  std::filesystem::path path_;
  pid_t ffmpeg_ = -1;
  int pipe_ = -1;
};

}  // namespace clothsim
