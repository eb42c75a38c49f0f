#pragma once
// Files of a folder on the disk, served below a path: "/docs/guide.html" is <folder>/guide.html.
//
// Only plain files are sent: no links, no hidden files, no list of what is in a folder, and a
// folder is its index.html. Each part of a path is opened below the one before it, without
// following links, so that no path, however it is written, leaves the folder.
//
// Threads: one at a time. A file is read in one piece.

#include <optional>
#include <string>
#include <string_view>

#include "musher/view/http/server.hpp"

namespace musher::http {

class Folder {
 public:
  static constexpr std::int64_t kLargest = 16 << 20;  // bytes of a file; a larger one is not sent

  // `below`: "/docs".
  Folder(std::string folder, std::string below);

  // The response to a request for `below` or what is in it: the file, 303 of a folder to its path
  // with '/', 304 if the client has the file, 404, 405 if it is not GET. nullopt: another path.
  std::optional<Response> Respond(const Request& request) const;

 private:
  std::string folder_;
  std::string below_;
};

// "text/html; charset=utf-8" of "a.html"; "application/octet-stream" of an unknown kind.
std::string_view ContentTypeOfFile(std::string_view name);

}  // namespace musher::http
