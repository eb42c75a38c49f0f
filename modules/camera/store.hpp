#pragma once
// The folder of pictures and videos that camera_service writes.
//
// Threads: called on the loop and never blocks it: the work is done elsewhere, in order, and
// `done` runs on the loop later. The destructor waits for work that has begun.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::camera {

// A plain name (FaultOfName()) for a new file.
struct NewFile {
  std::string name;
  // If there is such a file already: take the next free one of name_2, name_3 and so on, instead
  // of failing with 4410.
  bool counts_on = false;
};

class Store {
 public:
  template <class T>
  using Done = std::function<void(const Result<T>&)>;

  virtual ~Store() = default;

  // Returns the path of the file.
  virtual void Save(msg::Image picture, const NewFile& file, Done<std::string> done) = 0;

  // One video at a time. Its pictures, bgr8, all have the size of `first`.
  virtual void BeginVideo(msg::Image first, const NewFile& file, double rate_hz,
                          Done<std::string> done) = 0;
  // Dropped when too many wait.
  virtual void AddFrame(msg::Image picture) = 0;
  virtual void EndVideo(Done<std::string> done) = 0;

  virtual void List(Done<std::vector<std::string>> done) = 0;
  virtual void Delete(const std::string& file, Done<void> done) = 0;
};

// Creates the folder on the first write. Refuses to write when less than 16 MiB are free.
std::unique_ptr<Store> MakeStore(transport::EventLoop& loop, const std::string& folder);

}  // namespace musher::camera
