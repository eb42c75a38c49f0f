#pragma once
// The folder of the photos that a robot takes. A photo is encoded and written by a thread of its
// own; a reader gets the whole file or none.
//
// Threads: the loop's. The destructor waits for the photos that are being written.

#include <string>

#include "musher/base/work_queue.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::skills {

// The absolute path of a photo. `name` is relative to `folder`, or an absolute path inside of it,
// and ends with ".png". Fails for a path outside of the folder, also by "..", or by a link that
// leads out. Queries the file system for links.
Result<std::string> PhotoPath(const std::string& folder, const std::string& name);

class PhotoFolder {
 public:
  // `folder` is made when the first photo is saved. The loop must outlive it.
  PhotoFolder(std::string folder, transport::EventLoop& loop)
      : folder_(std::move(folder)), loop_(loop) {}

  // The path of the written file.
  skill::Future<std::string> Save(const Picture& picture, const std::string& name);

 private:
  const std::string folder_;
  transport::EventLoop& loop_;
  WorkQueue writer_{{.name = "photos"}};
};

}  // namespace musher::skills
