#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace clothsim {

/// A video file that ffmpeg writes while pictures come, so that none of them waits on disk.
class Video {
 public:
  /// Of pictures of width x height pixels, `rate` [Hz] of them; the ending names the format, as
  /// .mp4. Throws std::runtime_error where there is no ffmpeg.
  Video(const std::filesystem::path& path, int width, int height, double rate);

  /// Without finish() ffmpeg ends with what it has.
  ~Video();
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  /// Bytes r, g, b of each pixel, top row first. Throws std::runtime_error where ffmpeg has ended.
  void append(const std::vector<std::uint8_t>& rgb);

  /// Waits for the file to be complete. Throws std::runtime_error where ffmpeg fails; it has then
  /// told why.
  void finish();

 private:
  bool end();

  std::filesystem::path path_;
  pid_t ffmpeg_ = -1;
  int pipe_ = -1;
};

}  // namespace clothsim
