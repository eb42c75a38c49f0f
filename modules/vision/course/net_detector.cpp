#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/course/words.hpp"

namespace musher::vision {
namespace {

class NetDetector : public CourseDetector {
 public:
  NetDetector(NetParameters parameters, std::unique_ptr<Net> net, SteadyClock now)
      : parameters_(std::move(parameters)),
        net_(std::move(net)),
        now_(std::move(now)),
        words_(parameters_.min_repeats) {}

  CourseSight Look(const cv::Mat& bgr, std::int64_t /*stamp_ns*/,
                   const std::optional<Lens>& lens) override {
    const Duration begin = now_();
    const NetLook look = net_->Look(bgr);
    const Duration took = now_() - begin;
    boxes_ = look.boxes;
    CourseSight sight;
    sight.doubt = look.doubt;
    if (sight.doubt.empty() && took > parameters_.longest) {
      sight.doubt = "the network took " + std::to_string(ToMilliseconds(took)) +
                    " ms for a picture: what it shows is old";
    }
    if (!sight.doubt.empty()) {  // neither a picture with a thing nor one without
      words_.OnPicture(std::nullopt);
      boxes_.clear();
      return sight;
    }
    sight.sighting = NoSighting();
    const bool is_sure = !boxes_.empty() && IsSure();
    sight.text = words_.OnPicture(is_sure ? std::optional(LabelOf(boxes_.front())) : std::nullopt);
    if (boxes_.empty()) return sight;
    const cv::Rect2d& box = boxes_.front().box;
    sight.sighting = SightingAt(cv::Rect(box) & cv::Rect({0, 0}, bgr.size()), bgr.size());
    // At the picture's edge the box no longer grows, and the thing would seem to stay away.
    constexpr double kEdgePx = 1;
    const bool cut = box.y <= kEdgePx || box.br().y >= bgr.rows - kEdgePx;
    if (parameters_.height_m > 0 && !cut) {
      sight.sighting->distance_m = static_cast<float>(DistanceBySizeM(
          lens, bgr.size(), box.height, parameters_.height_m, parameters_.focal_px));
    }
    if (!sight.text) return sight;
    sight.sighting->text = *sight.text;
    const double least = parameters_.least_confidence;
    sight.sighting->confidence =
        ConfidenceBy({(boxes_.front().confidence - least) / std::max(1 - least, 1e-6)});
    return sight;
  }

  void Draw(cv::Mat& bgr) const override {
    for (const NetBox& box : boxes_) {
      const int percent = static_cast<int>(100 * box.confidence);
      DrawBox(bgr, box.box, LabelOf(box) + " " + std::to_string(percent) + " %");
    }
  }

 private:
  const std::string& LabelOf(const NetBox& box) const { return parameters_.labels.at(box.label); }

  // No other label is nearly as confident: which of them is meant would not be known.
  bool IsSure() const {
    constexpr double kNearly = 0.8;
    const NetBox& best = boxes_.front();
    return std::ranges::none_of(boxes_, [&](const NetBox& box) {
      return box.label != best.label && box.confidence >= kNearly * best.confidence;
    });
  }

  const NetParameters parameters_;
  const std::unique_ptr<Net> net_;
  const SteadyClock now_;
  WordRepeats words_;
  std::vector<NetBox> boxes_;
};

}  // namespace

Result<std::unique_ptr<CourseDetector>> MakeNetDetector(const NetParameters& parameters,
                                                        SteadyClock now) {
  auto net = Net::Load(parameters);
  if (!net) return Error{net.error().code, parameters.model + ": " + net.error().message};
  return std::unique_ptr<CourseDetector>(
      new NetDetector(parameters, std::move(net).value(), std::move(now)));
}

Duration SteadyNow() {
  return std::chrono::steady_clock::now().time_since_epoch();
}

}  // namespace musher::vision
