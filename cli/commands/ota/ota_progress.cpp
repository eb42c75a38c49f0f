#include "musher/cli/commands/ota/ota_progress.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "musher/cli/render/json.hpp"

namespace musher::cli {
namespace {

constexpr const char* kEraseLine = "\r\033[K";

}  // namespace

void OtaProgress::Begin(std::string_view step, std::uint64_t total_bytes) {
  step_ = step;
  total_bytes_ = total_bytes;
  bytes_ = 0;
  percent_ = -1;
  Draw();
}

void OtaProgress::Add(std::uint64_t bytes) {
  bytes_ += bytes;
  Draw();
}

void OtaProgress::End() {
  Clear();
  if (console_.mode().json) {
    console_.Print(OtaStepJson(step_, bytes_));
  } else if (!console_.mode().terminal) {
    console_.Print(bytes_ == 0
                       ? step_
                       : fmt::format("{}: {:.1f} MB", step_, static_cast<double>(bytes_) / 1e6));
  }
}

void OtaProgress::Draw() {
  if (!console_.mode().terminal || console_.mode().json) return;
  const auto percent =
      total_bytes_ == 0 ? 0 : static_cast<int>(std::min(bytes_, total_bytes_) * 100 / total_bytes_);
  if (percent == percent_) return;
  percent_ = percent;
  console_.Redraw(total_bytes_ == 0 ? fmt::format("{}{}...", kEraseLine, step_)
                                    : fmt::format("{}{} {:3} %", kEraseLine, step_, percent));
}

void OtaProgress::Clear() {
  if (percent_ >= 0) console_.Redraw(kEraseLine);
  percent_ = -1;
}

}  // namespace musher::cli
