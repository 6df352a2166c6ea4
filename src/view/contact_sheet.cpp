#include "clothsim/view/contact_sheet.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace clothsim {
namespace {

constexpr int gap = 4;            // [pixel] between tiles
constexpr int margin = 8;         // [pixel] around a label
constexpr double scale = 0.5;     // of OpenCV's font
constexpr double dimming = 0.35;  // brightness of the picture behind a label

cv::Mat view_of(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.rgb.data()));
}

void write_label(cv::Mat& tile, const std::string& label) {
  int below = 0;
  const cv::Size size = cv::getTextSize(label, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &below);
  cv::Mat behind = tile(cv::Rect(0, 0, size.width + 2 * margin, size.height + below + margin) &
                        cv::Rect(0, 0, tile.cols, tile.rows));
  behind *= dimming;
  cv::putText(tile, label, {margin, margin / 2 + size.height}, cv::FONT_HERSHEY_SIMPLEX, scale,
              {255, 255, 255}, 1, cv::LINE_AA);
}

}  // namespace

Image contact_sheet(const std::vector<Tile>& tiles, int columns) {
  const int count = static_cast<int>(tiles.size());
  columns = std::clamp(columns, 1, count);
  const int rows = (count + columns - 1) / columns;
  const int width = tiles[0].image.width, height = tiles[0].image.height;
  Image sheet{columns * (width + gap) - gap, rows * (height + gap) - gap, {}};
  sheet.rgb.assign(
      static_cast<std::size_t>(3 * sheet.width) * static_cast<std::size_t>(sheet.height), 255);
  cv::Mat whole = view_of(sheet);
  for (int i = 0; i < count; ++i) {
    const Tile& tile = tiles[static_cast<std::size_t>(i)];
    cv::Mat place = whole(
        cv::Rect((i % columns) * (width + gap), (i / columns) * (height + gap), width, height));
    view_of(tile.image).copyTo(place);
    if (!tile.label.empty()) write_label(place, tile.label);
  }
  return sheet;
}

}  // namespace clothsim
