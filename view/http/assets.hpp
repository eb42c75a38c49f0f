#pragma once
// Files that are part of the program: `musher_embed()` in CMakeLists.txt makes the table of a
// folder's files, with their content, and the owner declares the function that returns it:
//
//   musher_embed(musher_view_page musher::view::PageFiles ${CMAKE_CURRENT_SOURCE_DIR} *.html *.js)
//   namespace musher::view { std::span<const http::Asset> PageFiles(); }
//
// Pure; threads: any.

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "musher/view/http/server.hpp"

namespace musher::http {

struct Asset {
  std::string_view path;  // "/app.js"
  std::string_view content_type;
  std::string_view etag;  // with its quotes; changes with the content
  std::string_view content;
};

// The file of a path; of "/" and other folders their index.html. Null: none.
const Asset* FindAsset(std::span<const Asset> assets, std::string_view path);

// The response to a request for a file; nullopt: no file has that path. 304 if the client has it,
// 405 if it is not GET.
std::optional<Response> AssetResponse(std::span<const Asset> assets, const Request& request);

}  // namespace musher::http
