#include "musher/view/live/docs.hpp"

#include <filesystem>

#include "musher/base/program_path.hpp"

namespace musher::view {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPath = "/docs";

constexpr const char* kNotInstalled =
    "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
    "<title>Musher: documentation</title>\n<link rel=\"stylesheet\" href=\"/style.css\">\n"
    "<main>\n<h1>The documentation is not installed</h1>\n"
    "<p>Install the package <code>musher-doc</code> on the robot and reload this page; or, in a "
    "clone, <code>cmake --build --preset dev --target docs</code>, or <code>musher view --docs "
    "FOLDER</code> with a folder of its HTML.</p>\n"
    "<p lang=\"zh-CN\">文档尚未安装。请在机器人上安装软件包 "
    "<code>musher-doc</code>，然后刷新本页。</p>\n"
    "<p><a href=\"/\">Musher</a></p>\n</main></html>\n";

}  // namespace

std::optional<http::Response> Docs::Respond(const http::Request& request) {
  if (request.path != kPath && !request.path.starts_with(std::string(kPath) + "/")) {
    return std::nullopt;
  }
  if (!folder_ && find_) {
    const std::string folder = find_();
    if (!folder.empty()) folder_.emplace(folder, kPath);
  }
  if (folder_) return folder_->Respond(request);
  http::Response response;
  response.status = 404;
  response.content_type = "text/html; charset=utf-8";
  response.body = std::make_shared<const std::string>(kNotInstalled);
  return response;
}

std::string FindDocs() {
  const fs::path program = OwnProgram();
  if (program.empty()) return "";
  const fs::path above = program.parent_path().parent_path();
  for (const fs::path& folder : {above / MUSHER_DOC_FOLDER / "html", above / "docs" / "html"}) {
    std::error_code error;
    if (fs::is_regular_file(folder / "index.html", error)) return folder.string();
  }
  return "";
}

}  // namespace musher::view
