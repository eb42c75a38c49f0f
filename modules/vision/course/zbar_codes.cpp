#include "musher/modules/vision/course/zbar_codes.hpp"

#include <zbar.h>

#include <opencv2/imgproc.hpp>

namespace musher::vision {

std::vector<CodeFound> CodesOfZBar(const cv::Mat& grey) {
  zbar::ImageScanner scanner;
  scanner.set_config(zbar::ZBAR_NONE, zbar::ZBAR_CFG_ENABLE, 0);
  scanner.set_config(zbar::ZBAR_QRCODE, zbar::ZBAR_CFG_ENABLE, 1);
  const cv::Mat whole = grey.isContinuous() ? grey : grey.clone();
  zbar::Image picture(static_cast<unsigned>(whole.cols), static_cast<unsigned>(whole.rows), "Y800",
                      whole.data, whole.total());
  scanner.scan(picture);
  std::vector<CodeFound> codes;
  for (auto symbol = picture.symbol_begin(); symbol != picture.symbol_end(); ++symbol) {
    Contour corners;
    for (unsigned i = 0; i < static_cast<unsigned>(symbol->get_location_size()); ++i) {
      corners.emplace_back(symbol->get_location_x(i), symbol->get_location_y(i));
    }
    if (!corners.empty()) codes.push_back({symbol->get_data(), cv::boundingRect(corners)});
  }
  return codes;
}

}  // namespace musher::vision
