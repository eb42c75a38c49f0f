#pragma once
// The documentation of Musher under /docs, from the folder that the package musher-doc, or an
// install of the component doc, puts beside the programs; without it a page that says so. It shows
// nothing of the robot, so that no login is needed. Threads: one at a time.

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "musher/view/http/folder.hpp"

namespace musher::view {

class Docs {
 public:
  // `find` gives its folder; empty: there is none yet. It is called again until there is one.
  explicit Docs(std::function<std::string()> find) : find_(std::move(find)) {}

  // nullopt: not a path of the documentation.
  std::optional<http::Response> Respond(const http::Request& request);

 private:
  const std::function<std::string()> find_;
  std::optional<http::Folder> folder_;
};

// The folder of the documentation of this program: installed, or built in the same build folder.
// Empty: none is there.
std::string FindDocs();

}  // namespace musher::view
