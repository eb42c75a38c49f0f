#pragma once
// Selects pictures by the changes of a text: one after each, delayed so that it shows the effect.
// Uses the stamps of the pictures. Pure.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace musher::camera::tool {

class Caption {
 public:
  explicit Caption(std::int64_t settle_ns) : settle_ns_(settle_ns) {}

  // The same text again is no change. A change before the last one's picture replaces it.
  void OnText(std::string text) {
    if (text == text_) return;
    text_ = std::move(text);
    pending_ = true;
    changed_ns_.reset();
  }

  // Whether this picture shows the last change.
  bool Due(std::int64_t stamp_ns) {
    if (!pending_) return false;
    // The first picture after the change sets its time; also after time jumps back.
    if (!changed_ns_ || stamp_ns < *changed_ns_) changed_ns_ = stamp_ns;
    if (stamp_ns < *changed_ns_ + settle_ns_) return false;
    pending_ = false;
    return true;
  }

  const std::string& text() const { return text_; }
  // Whether the last change has no picture yet.
  bool pending() const { return pending_; }

 private:
  const std::int64_t settle_ns_;
  std::string text_;
  bool pending_ = false;
  std::optional<std::int64_t> changed_ns_;
};

}  // namespace musher::camera::tool
