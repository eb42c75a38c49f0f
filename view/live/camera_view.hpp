#pragma once
// Pictures of camera topics as JPEG, for pages. A topic is subscribed to while a page requests
// its pictures, and only the newest picture is kept: a slow page gets fewer, never older ones.
//
// Threads: loop thread only; a picture of 640 × 480 takes some 2 ms of it, once for all pages that
// request the same width.

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "musher/transport/node.hpp"
#include "musher/view/http/server.hpp"
#include "musher/view/topics/topic_table.hpp"

namespace musher::view {

class CameraView {
 public:
  static constexpr Duration kTimeout = std::chrono::seconds(2);
  static constexpr Duration kKept = std::chrono::seconds(5);  // after the last request

  // The node and the table must outlive it.
  CameraView(transport::Node& node, const TopicTable& table) : node_(node), table_(table) {}

  // The newest picture of the topic that came later than `after_ms` (X-Stamp-Ms of the one before;
  // 0: any), not wider than `width` pixels (0: as it is): a JPEG with X-Stamp-Ms, the time of its
  // receipt since 1970. Waits kTimeout for one, then 204. 404: no camera publishes the topic.
  void Get(const std::string& topic, std::int64_t after_ms, int width,
           const http::Respond& respond);

 private:
  struct Request {
    std::int64_t after_ms;
    int width;
    http::Respond respond;
    Time until;
  };
  struct Camera {
    TopicTable::Source source;
    msg::Bytes newest;  // its message
    std::int64_t stamp_ms = 0;
    std::map<int, std::shared_ptr<const std::string>> jpegs;  // of the newest, by width
    std::list<Request> waiting;
    Time requested_at;
    std::unique_ptr<transport::RawReader> reader;  // last: its callback uses all of the above
  };

  void OnPicture(Camera& camera, std::span<const std::byte> bytes);
  void Answer(Camera& camera, int width, const http::Respond& respond);
  void Look();

  transport::Node& node_;
  const TopicTable& table_;
  std::map<std::string, Camera> cameras_;
  transport::LoopHandlePtr timer_;  // while there are cameras
};

// The picture of a message sensor_msgs/Image (rgb8, bgr8, rgba8, bgra8, mono8, mono16) or
// CompressedImage (JPEG, PNG) as JPEG. Errors: a sentence on what is wrong with it.
Result<std::string> JpegOf(std::string_view dds_type, std::span<const std::byte> cdr, int width);
bool IsPicture(std::string_view dds_type);

}  // namespace musher::view
