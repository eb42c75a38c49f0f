#pragma once
// Selects the pictures of a strip: one of each camera whenever one is due, by the stamps of the
// first camera's pictures. Pure, but for the log of a picture that cannot be read.
//
//   Take(0, …) due: a tile begins    Take(1, …), Take(2, …): it is complete
//
// A tile whose other cameras have no picture when the next one is due is taken without them.
//
// Threads: one at a time.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/camera/pace.hpp"
#include "musher/modules/camera/tool/caption.hpp"
#include "musher/modules/camera/tool/options.hpp"
#include "musher/modules/camera/tool/strip_picture.hpp"

namespace musher::camera::tool {

class Collector {
 public:
  explicit Collector(const StripOptions& options);

  void OnText(const std::string& text) { caption_.OnText(text); }

  // `camera`: 0 is the topic itself, the others those beside it, in their sequence.
  void Take(std::size_t camera, msg::Image picture);

  // Whether the cameras are needed now. Always, unless they are opened on demand.
  bool NeedsPictures() const;
  bool done() const { return static_cast<int>(tiles_.size()) >= options_.count && !begun_; }
  // Also with a last one that is not complete.
  std::vector<StripTile> Tiles() const;
  const std::optional<Error>& unreadable() const { return unreadable_; }

 private:
  // A tile that waits for pictures of other cameras.
  struct Begun {
    std::vector<std::optional<msg::Image>> pictures;  // of each camera
    std::string label;
    bool Complete() const;
  };

  bool Due(std::int64_t stamp_ns);
  void Begin(std::int64_t stamp_ns);
  void Finish();

  const StripOptions options_;
  Pace pace_;
  Caption caption_;
  std::optional<std::int64_t> first_ns_;
  std::optional<Begun> begun_;
  std::vector<StripTile> tiles_;
  std::optional<Error> unreadable_;
};

}  // namespace musher::camera::tool
